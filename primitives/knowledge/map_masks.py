"""Masks over a map, as nav2 has them: where to keep out, where to drive slowly."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from handcart.files.errors import Finding
from handcart.files.maps.map_file import read_occupancy
from handcart.files.models.loading import Loaded
from handcart.files.models.model import FileModel
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.keepout import keepout_cells
from handcart.robotics.navigation.maps.speed_limits import SpeedLimits

from .place import Places


class SpeedMask(FileModel):
    """Mask over the map that limits the speed of the robot's base, with a value from 0 to 100 in each cell.

    The limit in a cell is `base + multiplier * value`, in percent of the top speed or in [m/s] (`type`). A
    value of 0 means no limit.
    """

    mask: str
    """A file in ROS format, usually with `mode: scale`."""
    type: Literal["percent", "absolute"] = "percent"
    """Unit of the limit: percent of the robot's top speed (nav2's type 1) or m/s (type 2)."""
    base: float = 0.0
    multiplier: float = 1.0


def load_speed_limits(path: Path, spec: SpeedMask) -> SpeedLimits:
    """Return the limits of the base's speed in each cell of a mask: a map whose values represent speeds.

    Args:
        path: the mask's file, in ROS's format of maps.
        spec: scale and unit of the mask's values.

    Raises:
        FileError: the file is missing or its content is invalid.
    """
    read = read_occupancy(path)
    percent = spec.type == "percent"
    return SpeedLimits(read.values, read.resolution, read.origin, percent, spec.base, spec.multiplier)


def keepout_findings(places: Loaded[Places], grid: GridMap, zones: GridMap, mask: Path) -> Iterator[Finding]:
    """Yield a finding for each place inside a keepout zone.

    Args:
        places: places, with the lines of their file.
        grid: the map; places beyond it are not checked.
        zones: keepout zones, as a map whose occupied cells are forbidden.
        mask: file of the zones, named in the findings.
    """
    barred = keepout_cells(grid, zones)
    for name, place in places.value.places.items():
        point = place.pose.lift()[None, :2, 3]
        if grid.inside(point)[0] and barred[tuple(grid.to_cell(point)[0])]:
            wrong = f"place {name!r} lies where {mask.name} keeps the robot out; allowed: elsewhere"
            yield places.finding(("places", name), wrong, at_key=True)
