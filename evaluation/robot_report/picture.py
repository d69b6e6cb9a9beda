"""Picture of a robot from the side and from above, in its postures, with the reach of its hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull

from handcart.backends.description.robot_file import RobotFile
from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.plain_text import plain
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.kinematics.shapes import Shape
from handcart.robotics.kinematics.urdf_contents import bodies_of
from handcart.robotics.numerics.arrays import FloatArray

from .masses import corners_of
from .reach import HandReach

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_POSTURES = 6
STILL, MOVED, FRONT, REACHED, EDGE = "#9aa3ad", "#4a78b5", "#c8382e", "#e8f1e4", "#3a3f45"
REACH_CELL_M = 0.06
VIEW_AXES = {"from the side": (0, 2), "from above": (0, 1)}


def draw_robot(path: Path, robot: RobotFile, reach: HandReach | None) -> None:
    """Draw a robot into a file; the suffix (svg, png, pdf) selects the format.

    Args:
        path: the file.
        robot: the robot's file.
        reach: reach of its arm; None: it is not drawn.

    Raises:
        OSError: the file cannot be written.
        ValueError: the suffix is not that of a picture.
    """
    from matplotlib.figure import Figure

    columns, still = _columns(robot), _still(robot)
    figure = Figure(figsize=(1.0 + 3.1 * len(columns), 6.4), layout="constrained")
    axes = figure.subplots(len(VIEW_AXES), len(columns), squeeze=False, sharex=True, sharey="row")
    for row, (view, (across, up)) in zip(axes, VIEW_AXES.items(), strict=True):
        for item, (name, bodies) in zip(row, columns.items(), strict=True):
            _draw(item, bodies, still, (across, up), reach, robot.footprint_shape)
            item.set_title(plain(f"{name}, {view}" if name else view), fontsize=8)
        row[0].set_ylabel("z [m]" if up == 2 else "y [m], left up", fontsize=8)
    for item in axes[-1]:
        item.set_xlabel("x [m], ahead", fontsize=8)
    save_figure(figure, path)


def _columns(robot: RobotFile) -> dict[str, Sequence[Shape]]:
    """Return the bodies in the base frame by posture, with equal postures merged."""
    if robot.arm is None:
        return {"": bodies_of(robot.urdf_text())}
    arm = robot.arm_model()
    named: dict[tuple[float, ...], list[str]] = {}
    for name in robot.arm.postures:
        named.setdefault(robot.posture(name), []).append(name)
    chosen = list(named.items())[:MAX_POSTURES] or [(tuple(np.zeros(arm.dof)), ["all joints at zero"])]
    return {", ".join(names): arm.link_shapes(np.array(angles)) for angles, names in chosen}


def _still(robot: RobotFile) -> set[str]:
    """Return the names of the links that the arm does not move."""
    if robot.arm is None:
        return {item.name for item in bodies_of(robot.urdf_text())}
    arm = robot.arm_model()
    middle = 0.5 * (arm.lower + arm.upper)
    both = zip(arm.link_shapes(middle), arm.link_shapes(middle + 0.1), strict=True)
    return {here.name for here, there in both if np.allclose(here.pose, there.pose)}


def _draw(
    axes: Axes,
    bodies: Sequence[Shape],
    still: set[str],
    view: tuple[int, int],
    reach: HandReach | None,
    footprint: Footprint,
) -> None:
    from matplotlib.patches import Polygon

    across, up = view
    if reach is not None:
        _shade(axes, reach.points[:, [across, up]])
    for body in sorted(bodies, key=lambda shape: float(shape.pose[3 - across - up, 3])):
        outline = _outline(corners_of(body)[:, [across, up]])
        colour = FRONT if "finger" in body.name or "camera" in body.name else MOVED
        face = STILL if body.name in still else colour
        axes.add_patch(Polygon(outline, facecolor=face, edgecolor=EDGE, linewidth=0.5, alpha=0.75))
    if up == 2:
        axes.axhline(0.0, color=EDGE, linewidth=0.8)
    else:
        axes.plot(*footprint.outline(0.0, 0.0, 0.0).T, color=FRONT, linewidth=0.9, linestyle="--")
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.tick_params(labelsize=7)
    axes.grid(linewidth=0.3, alpha=0.6)
    axes.set_axisbelow(True)


def _shade(axes: Axes, points: FloatArray) -> None:
    """Shade the cells that the hand reached, at points (n, 2) projected into the view, in [m]."""
    low = np.floor(points.min(axis=0) / REACH_CELL_M).astype(int) - 1
    cells = np.floor(points / REACH_CELL_M).astype(int) - low
    counts = np.zeros(cells.max(axis=0) + 2)
    np.add.at(counts, (cells[:, 0], cells[:, 1]), 1.0)
    x, y = ((low[axis] + np.arange(counts.shape[axis]) + 0.5) * REACH_CELL_M for axis in (0, 1))
    axes.contourf(x, y, counts.T, levels=[0.5, np.inf], colors=[REACHED])


def _outline(points: FloatArray) -> FloatArray:
    return np.asarray(points[ConvexHull(points).vertices])
