"""Picture of two maps, one over the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import BLUE, VERMILION
from handcart.evaluation.viewing.drawing.plain_text import plain
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.map_comparison import wall_points
from handcart.robotics.navigation.maps.grid_map import GridMap

WIDTH_IN, MAX_HEIGHT_IN, POINTS_PER_IN = 9.0, 14.0, 72.0


def draw_comparison(
    grids: tuple[GridMap, GridMap], first_T_second: Pose2, path: Path, names: tuple[str, str]
) -> None:
    """Draw the walls of two maps in the frame of the first.

    Args:
        grids: the two maps.
        first_T_second: pose of the second map's frame in the frame of the first.
        path: file to write.
        names: names of the two maps in the legend.

    Raises:
        OSError: the file cannot be written.
    """
    walls = wall_points(grids[0]), first_T_second.apply(wall_points(grids[1]))
    size = np.ptp(np.concatenate(walls), axis=0)
    height = min(MAX_HEIGHT_IN, 1.5 + WIDTH_IN * float(size[1]) / max(float(size[0]), 1.0))
    figure = Figure(figsize=(WIDTH_IN, height), layout="constrained")
    axis: Any = figure.add_subplot()
    for points, colour, name in zip(walls, (BLUE, VERMILION), names, strict=True):
        axis.plot(*points.T, ",", color=colour, label=plain(name), rasterized=True)
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), markerscale=POINTS_PER_IN / 6.0)
    save_figure(figure, path)
