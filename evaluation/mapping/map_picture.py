"""Picture of a map with the trajectory, its uncertainty and the loop closures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import BLUE, GREEN, VERMILION
from handcart.evaluation.viewing.drawing.plain_text import plain
from handcart.robotics.navigation.mapping.map_building import BuiltMap

WIDTH_IN = 9.0
MAX_HEIGHT_IN = 14.0
ELLIPSE_COUNT = 30
ELLIPSE_SIGMAS = 3.0
MAX_DRAWN_LOOPS = 500
OCCUPIED_LEVEL, UNKNOWN_LEVEL, FREE_LEVEL = 0.0, 0.85, 1.0


def draw_map(built: BuiltMap, path: Path, title: str) -> None:
    """Draw a built map: its cells, the trajectory with ellipses of three sigma, and the loop closures.

    Raises:
        OSError: the file cannot be written.
    """
    grid = built.counts.grid
    rows, columns = grid.occupied.shape
    height = min(MAX_HEIGHT_IN, 1.2 + WIDTH_IN * rows / columns)
    figure = Figure(figsize=(WIDTH_IN, height), layout="constrained")
    axis: Any = figure.add_subplot()
    level = np.where(grid.occupied, OCCUPIED_LEVEL, np.where(grid.unknown, UNKNOWN_LEVEL, FREE_LEVEL))
    right, top = grid.origin_x + columns * grid.resolution, grid.origin_y + rows * grid.resolution
    extent = (grid.origin_x, right, grid.origin_y, top)
    axis.imshow(
        level, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent, interpolation="nearest"
    )
    _draw_loops(axis, built)
    axis.plot(*built.poses[:, :2].T, color=BLUE, linewidth=1.0, label="trajectory")
    _draw_ellipses(axis, built)
    axis.set_title(plain(title))
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    save_figure(figure, path)


def _draw_loops(axis: Any, built: BuiltMap) -> None:
    stride = max(1, math.ceil(len(built.accepted) / MAX_DRAWN_LOOPS))
    ends = [built.poses[[loop.first, loop.second], :2] for loop in built.accepted[::stride]]
    if ends:
        lines = LineCollection(
            ends, colors=GREEN, linewidths=0.6, label=f"{len(built.accepted)} loop closures"
        )
        axis.add_collection(lines)


def _draw_ellipses(axis: Any, built: BuiltMap) -> None:
    label = f"uncertainty, {ELLIPSE_SIGMAS:g} sigma"
    for number in np.unique(np.linspace(0, len(built.poses) - 1, ELLIPSE_COUNT).astype(int)):
        values, vectors = np.linalg.eigh(built.covariances[number, :2, :2])
        long, short = 2.0 * ELLIPSE_SIGMAS * np.sqrt(np.maximum(values[::-1], 0.0))
        angle = math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
        centre = tuple(built.poses[number, :2])
        axis.add_patch(
            Ellipse(centre, long, short, angle=angle, fill=False, edgecolor=VERMILION, label=label)
        )
        label = ""
