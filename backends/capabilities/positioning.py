"""Positioning: an indoor system that measures the pose of the base."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, NamedTuple

from handcart.robotics.geometry.pose2 import Pose2

from .capability import Capability, Reading


class PoseReading(NamedTuple):
    """Pose of the base, measured by an indoor positioning system."""

    number: int
    """Readings so far, from 1: another number is another reading."""
    pose: Pose2
    """map_T_base at the instant of the measurement."""
    age: float
    """Age of the measurement, in [s]."""


class Positioning(Capability):
    """Indoor positioning system, such as laser trackers or ceiling cameras, which measures map_T_base."""

    READINGS: ClassVar = {"reading": Reading("positioning")}

    @abstractmethod
    def reading(self) -> PoseReading | None:
        """Return the latest pose reading that has arrived; None before the first."""
