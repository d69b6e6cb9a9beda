"""What the grey levels of a map picture mean to ROS (nav2's map_server)."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Mode = Literal["trinary", "scale", "raw"]
UNKNOWN = -1
OCCUPIED = 100
FREE = 0
UNKNOWN_GREY = 205  # what map_saver writes where nothing was measured


def occupancy_of_levels(negate: bool) -> NDArray[np.float64]:
    """(256,): the occupancy 0 to 1 that each grey level stands for; dark is occupied, unless `negate`."""
    level = np.arange(256) / 255.0
    return level if negate else 1.0 - level


def ros_occupancy(
    image: NDArray[np.uint8],
    mode: Mode,
    occupied_thresh: float,
    free_thresh: float,
    negate: bool = False,
    opaque: NDArray[np.bool_] | None = None,
) -> NDArray[np.int8]:
    """Occupancy (h, w) in percent, -1 for unknown, row 0 at the bottom: an OccupancyGrid's data.

    After nav2_map_server/src/map_io.cpp: `trinary` knows 0, 100 and unknown; `scale` also what lies between
    the thresholds; `raw` takes levels of 0 to 100 as they are, and others for unknown.

    Args:
        image: (h, w) grey, row 0 on top, as in the file.
        mode: of the three.
        occupied_thresh: from this occupancy on a cell is occupied.
        free_thresh: up to this occupancy a cell is free.
        negate: dark means free.
        opaque: (h, w); where a picture is transparent nothing is known, but in mode `raw`.
    """
    if mode == "raw":
        levels = np.arange(256)
        table = np.where(levels <= OCCUPIED, levels, UNKNOWN).astype(np.int8)
        opaque = None
    else:
        table = _table(occupancy_of_levels(negate), mode, occupied_thresh, free_thresh)
    values = table[image]
    if opaque is not None:
        values[~opaque] = UNKNOWN
    return values[::-1]


def _table(
    level: NDArray[np.float64], mode: Mode, occupied_thresh: float, free_thresh: float
) -> NDArray[np.int8]:
    between = np.full(256, float(UNKNOWN))
    if mode == "scale":
        between = np.floor(100.0 * (level - free_thresh) / (occupied_thresh - free_thresh) + 0.5)
    found = np.where(level >= occupied_thresh, OCCUPIED, between)
    table: NDArray[np.int8] = np.where(level <= free_thresh, FREE, found).astype(np.int8)
    return table
