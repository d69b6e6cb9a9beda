"""Radio beacons: ranges from the robot's own radio to some places that are known."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, NamedTuple

from handcart.robotics.numerics.arrays import FloatArray

from .capability import Capability, Reading


class BeaconRanges(NamedTuple):
    """Measured distances between the beacons and the robot's own radio, the tag."""

    distances: FloatArray
    """Distances (k,) in [m], in the order of the beacons in the robot's file; NaN for a beacon that wasn't
    heard.
    """


class Beacons(Capability):
    """Receiver on the robot that measures its ranges to radio beacons at fixed places, such as
    ultra-wideband.
    """

    READINGS: ClassVar = {"ranges": Reading("beacons", ("distances",))}

    @abstractmethod
    def ranges(self) -> BeaconRanges | None:
        """Return the ranges measured in the current control period; None if the radio measured nothing."""
