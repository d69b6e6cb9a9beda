"""A map that a primitive has drawn."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.navigation.mapping.map_building import BuiltMap
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray


class DrawnMap(NamedTuple):
    """Map that was made from sensor data during a run, with its keyframes and their uncertainty."""

    grid: GridMap
    """The cells, also those of a given map that it completes."""
    built: BuiltMap
    """Keyframes with their poses and covariances, and the loop closures."""
    times: FloatArray
    """Times (n,) of the keyframes, in [s]."""
