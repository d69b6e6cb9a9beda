"""Pictures of a path divided among base placements, after Shin (2005)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import SERIES_COLOURS
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.placement.placement_division import Division
from handcart.robotics.numerics.arrays import FloatArray

DRAWN_POSTURES = 7  # of the arm in a segment
DRAWN_BASE_M = (0.9, 0.65)  # [m] length and width of the base that is drawn


class DividedPath(NamedTuple):
    """Panel of a plot with a tool's path divided into parts, each tracked from one pose of the base."""

    title: str
    bases: FloatArray
    """(b, 3) base poses to whose rows the division refers, x, y in [m] and heading in [rad]."""
    division: Division


def draw_divisions(
    path: ToolPath, panels: Sequence[DividedPath], target: Path, arm: PitchArm | None = None
) -> None:
    """Draw a tool's path from above with the poses of the base, and from the side.

    The panels resemble figure 4 of Shin (2005). The side view has x to the right and z up.

    Args:
        path: path of the tool.
        panels: divisions to draw, one below the other.
        target: file to write.
        arm: arm whose postures are drawn from above; None: no arm is drawn.

    Raises:
        OSError: the file cannot be written.
    """
    figure, axes = _figure(2 * len(panels), (8.0, 4.2 * len(panels)), [2.2, 1.0] * len(panels))
    for above, ahead, panel in zip(axes[::2], axes[1::2], panels, strict=True):
        for colour, segment in _coloured(panel.division):
            part = path.part(segment.first, segment.last)
            base = panel.bases[segment.placement]
            above.plot(part.points[:, 0], part.points[:, 1], color=colour, linewidth=3.0)
            ahead.plot(part.points[:, 0], part.points[:, 2], color=colour, linewidth=3.0)
            _draw_base(above, base, colour)
            if arm is not None:
                _draw_arm(above, arm, base, part, colour)
        _label(above, panel, path)
        ahead.set_aspect("equal", adjustable="datalim")
        ahead.set_xlabel("x [m]")
        ahead.set_ylabel("z [m]")
    _save(figure, target)


def _figure(rows: int, size: tuple[float, float], ratios: Any = None) -> tuple[Any, list[Any]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(
        rows, squeeze=False, sharex=True, gridspec_kw={"height_ratios": ratios or [1] * rows}
    )
    return figure, list(axes.ravel())


def _coloured(division: Division) -> list[tuple[str, Any]]:
    return [
        (SERIES_COLOURS[row % len(SERIES_COLOURS)], segment) for row, segment in enumerate(division.segments)
    ]


def _label(ax: Any, panel: DividedPath, path: ToolPath) -> None:
    shares = " + ".join(
        f"{path.lengths[segment.last] - path.lengths[segment.first]:.2f}"
        for segment in panel.division.segments
    )
    ax.set_title(f"{panel.title}: {shares} m, score {panel.division.score / path.length:.3f}", fontsize=10)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_ylabel("y [m]")


def _draw_base(ax: Any, base: FloatArray, colour: str) -> None:
    cos, sin = np.cos(base[2]), np.sin(base[2])
    half = 0.5 * np.array(DRAWN_BASE_M)
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)]) * half
    outline = corners @ np.array([[cos, sin], [-sin, cos]]) + base[:2]
    ax.plot(outline[:, 0], outline[:, 1], color=colour, linewidth=1.0)
    ax.plot(*base[:2], "o", color=colour)
    ax.plot(
        *np.column_stack((base[:2], base[:2] + half[0] * np.array((cos, sin)))), color=colour, linewidth=2.0
    )


def _draw_arm(ax: Any, arm: PitchArm, base: FloatArray, part: ToolPath, colour: str) -> None:
    some = np.linspace(0, len(part.points) - 1, DRAWN_POSTURES).astype(int)
    shoulder = arm.shoulders(np.atleast_2d(base))[0]
    for angles in arm.joints(base, part)[some]:
        if np.isnan(angles).any():
            continue
        heading = base[2] + angles[0]
        reach = np.concatenate(([0.0], np.cumsum(np.array(arm.links) * np.cos(np.cumsum(angles[1:])))))
        knots = shoulder + reach[:, None] * np.array((np.cos(heading), np.sin(heading)))
        ax.plot(knots[:, 0], knots[:, 1], "-o", color=colour, markersize=2.5, linewidth=0.8, alpha=0.6)


def _save(figure: Any, target: Path) -> None:
    save_figure(figure, target, dpi=110)
