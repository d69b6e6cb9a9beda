"""The satellite receiver."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, NamedTuple

from handcart.robotics.numerics.arrays import FloatArray

from .capability import Capability, Reading


class Fix(NamedTuple):
    """A satellite receiver's measurement of its antenna's position."""

    position: FloatArray
    """Antenna position (2,), east and north of the task's origin, in [m]."""
    sigma: float
    """Sigma that the receiver states, on each axis, in [m]."""


class Gps(Capability):
    """A satellite receiver, whose antenna is at the origin of the URDF's frame `gps`."""

    READINGS: ClassVar = {"fix": Reading("gps")}

    @abstractmethod
    def fix(self) -> Fix | None:
        """Return the fix that arrived in the current control period; None if none arrived."""
