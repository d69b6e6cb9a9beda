"""A path divided among base placements, and the work of the tool along it."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.numerics.arrays import FloatArray

from .placement_division import PathSegment


class Work(NamedTuple):
    """Speed, force and tolerances of a tool along a path."""

    speed: float
    """[m/s]"""
    force: float
    """Along the path, at most, in [N]."""
    free: FreeTurn
    azimuth_tolerance: float
    """Azimuth tolerance used with FreeTurn.VERTICAL, in [rad]."""


class Placements(NamedTuple):
    """A path divided among places."""

    bases: FloatArray
    """(k, 3): x and y in [m], heading in [rad]; one for each segment."""
    segments: tuple[PathSegment, ...]
    """Their numbers are those of the path's points, placements those of `bases`."""
    scores: tuple[float, ...]
    """Integral along each segment, in [m]: up to its length."""

    @property
    def score(self) -> float:
        """Score of the complete path, in [m]."""
        return sum(self.scores)
