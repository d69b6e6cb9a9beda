"""One scan of a lidar: raw as its driver delivers it, or read, each beam with its validity."""

from __future__ import annotations

from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray

NO_ECHO_KINDS = np.empty(0, np.uint8)


class Validity(IntEnum):
    """Kind of a lidar beam's reading (a return, no return, too close, or invalid)."""

    RETURN = 0
    """Something is at its range."""
    NO_RETURN = 1
    """Nothing came back: the way along the beam counts as free."""
    TOO_CLOSE = 2
    """Something is nearer than the lidar can measure, or in the robot's footprint; it hides the space behind
    it.
    """
    INVALID = 3
    """No reading, or a masked one: the space along the beam is unknown."""


_TOO_CLOSE, _INVALID = int(Validity.TOO_CLOSE), int(Validity.INVALID)  # looked up in an enumeration slowly


class _Beams(NamedTuple):
    """Fields of a scan with n beams."""

    angles: FloatArray
    """Angles (n,) in [rad], in the sensor frame, counter-clockwise from its x axis."""
    ranges: FloatArray
    """Ranges (n,) in [m]; infinity without a return. In an interpreted scan, infinity for every beam whose
    validity isn't `RETURN`.
    """
    base_T_sensor: Pose2
    """2D pose of the sensor in the base frame."""
    validity: ByteArray = NO_ECHO_KINDS
    """Values (n,) of `Validity`; empty in a raw scan."""


class Scan(_Beams):
    """Readings of one turn of a lidar, or of the part of a turn that it sees."""

    def points(self) -> FloatArray:
        """Return the points (m, 2) at which beams hit something, in the base frame, in [m]."""
        return self._points

    @cached_property
    def _points(self) -> FloatArray:
        """Hit points (m, 2) in the base frame, in [m], computed once, because several callers need them."""
        hit = np.isfinite(self.ranges)
        reach, angle = self.ranges[hit], self.angles[hit]
        points = np.empty((len(reach), 2))
        points[:, 0], points[:, 1] = reach * np.cos(angle), reach * np.sin(angle)
        return self.base_T_sensor.apply(points)

    def blind(self) -> BoolArray:
        """Return a mask (n,), True for beams that show neither an obstacle nor free ground (too close or
        invalid).
        """
        return self.validity >= _TOO_CLOSE

    def rep117(self) -> FloatArray:
        """Return the ranges (n,) as REP 117 encodes them, in [m].

        Infinity is no return, -infinity too close, NaN invalid.
        """
        ranges = self.ranges.copy()
        if len(self.validity):
            ranges[self.validity == _TOO_CLOSE] = -np.inf
            ranges[self.validity == _INVALID] = np.nan
        return ranges
