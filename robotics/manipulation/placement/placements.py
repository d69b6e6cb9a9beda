"""A path divided among base placements, and the work of the tool along it."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.numerics.arrays import FloatArray

from .placement_division import PathSegment


class Work(NamedTuple):
    """Speed, force and tolerances of a tool along a path."""

    speed: float
    """Speed of the tool, in [m/s]."""
    force: float
    """Maximum force of the tool along the path, in [N]."""
    free: FreeTurn
    azimuth_tolerance: float
    """Azimuth tolerance used with FreeTurn.VERTICAL, in [rad]."""


class Placements(NamedTuple):
    """Path divided into segments, each with the pose of the base from which the arm tracks it."""

    bases: FloatArray
    """(k, 3): x and y in [m], heading in [rad]; one for each segment."""
    segments: tuple[PathSegment, ...]
    """Segments between points of the path; their `placement` is a row of `bases`."""
    scores: tuple[float, ...]
    """Integral of the score along each segment, in [m]; at most the segment's length."""

    @property
    def score(self) -> float:
        """Sum of the placements' scores, in [m]: the integral over the path's length of the score (0 to 1) of
        the arm at each point.
        """
        return sum(self.scores)
