"""A picture of how a drawn wall is built: from where, and in which order."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import GREY, SERIES_COLOURS
from handcart.evaluation.viewing.drawing.plain_text import plain
from handcart.robotics.geometry.pose2 import Pose2

from .wall_planning import WallPlan


def draw_wall(plan: WallPlan, radius: float, target: Path) -> None:
    """Draw the floor from above with the places where the base stops, and the front of the wall with the
    numbers of the blocks.

    Args:
        plan: plan of the wall.
        radius: radius of the base's footprint, in [m].
        target: file to write.

    Raises:
        OSError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 6.5), layout="constrained")
    above, front = figure.subplots(2, 1, height_ratios=(3.0, 1.0))
    _from_above(plan, radius, above)
    _from_front(plan, front)
    save_figure(figure, target)


def _from_above(plan: WallPlan, radius: float, ax: Any) -> None:
    from matplotlib.patches import Circle

    grid = plan.grid
    height, width = grid.occupied.shape
    right, top = grid.origin_x + width * grid.resolution, grid.origin_y + height * grid.resolution
    shown = np.where(grid.occupied, 2, np.where(plan.keepout.occupied, 1, 0))
    edges = (grid.origin_x, right, grid.origin_y, top)
    ax.imshow(shown, origin="lower", extent=edges, cmap="Greys", vmin=0, vmax=4)
    for table in plan.drawing.tables.values():
        _outline(ax, table.floor, *table.size_m, GREY)
    length, width_m, _ = plan.drawing.block
    for stops, places in (
        (plan.fetching, plan.drawing.supply),
        (plan.laying, [b.place for b in plan.blocks]),
    ):
        for colour, stop in zip(SERIES_COLOURS * len(stops), stops, strict=False):
            for number in stop.numbers:
                _outline(ax, places[number - 1].floor, length, width_m, colour)
            x, y, turn = stop.pose
            ax.add_patch(Circle((x, y), radius, fill=False, color=colour))
            ax.arrow(x, y, radius * np.cos(turn), radius * np.sin(turn), color=colour, width=0.01)
            ax.annotate(plain(stop.name), (x, y - 0.12), color=colour, ha="center", va="top", fontsize=8)
    for name, mark in plan.drawing.landmarks.items():
        ax.plot(mark.x_m, mark.y_m, "k+")
        behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
        ax.annotate(
            name,
            (mark.x_m, mark.y_m),
            (6, 0),
            textcoords="offset points",
            fontsize=7,
            va="center",
            bbox=behind,
        )
    ax.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="grey: what the base keeps out of")


def _from_front(plan: WallPlan, ax: Any) -> None:
    from matplotlib.patches import Rectangle

    row = plan.drawing.rows[0].floor
    _, width, height = plan.drawing.block
    for number, block in enumerate(plan.blocks, start=1):
        along, up = block.place.floor.relative_to(row).y, block.place.height_m
        colour = SERIES_COLOURS[_stop_of(plan, number) % len(SERIES_COLOURS)]
        ax.add_patch(Rectangle((along - width / 2, up), width, height, facecolor="none", edgecolor=colour))
        ax.annotate(str(number), (along, up + height / 2), ha="center", va="center", fontsize=8)
    ax.autoscale_view()
    ax.set(aspect="equal", xlabel="along the wall [m]", ylabel="height [m]", title="order of the blocks")


def _stop_of(plan: WallPlan, number: int) -> int:
    return next(index for index, stop in enumerate(plan.laying) if number in stop.numbers)


def _outline(ax: Any, floor: Pose2, length: float, width: float, colour: str) -> None:
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * (length / 2, width / 2)
    ax.plot(*floor.apply(corners).T, color=colour, linewidth=0.8)
