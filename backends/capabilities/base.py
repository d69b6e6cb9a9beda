"""The wheels."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, NamedTuple, Self

from typing_extensions import override

from .capability import Capability, Reading


class WheelTravel(NamedTuple):
    """Travel of the wheels since the backend was built, by their encoders and nominal radius."""

    left: float
    """Travel of the left side, in [m], positive forwards."""
    right: float
    """Travel of the right side, in [m], positive forwards."""
    sideways: float = 0.0
    """Travel to the left in [m] of a base that can drive sideways; its `left` and `right` are the travel of
    its sides.
    """

    def away(self, other: WheelTravel) -> float:
        """Return the largest of the absolute differences of left, right and sideways to `other`, in [m]."""
        return max(
            abs(self.left - other.left), abs(self.right - other.right), abs(self.sideways - other.sideways)
        )


class DriveCommand(NamedTuple):
    """Commanded speeds of a base for one control period."""

    speed: float = 0.0
    """Forward speed, in [m/s]."""
    turn_rate: float = 0.0
    """Turn rate to the left, in [rad/s]."""
    sideways: float = 0.0
    """Speed to the left, in [m/s]."""

    @property
    def direction(self) -> float:
        """Direction of travel in the base frame, in [rad], counter-clockwise from straight ahead.

        It is 0 for straight ahead. For straight back it is 0 too, with a negative `along`.
        """
        return math.atan2(self.sideways, self.speed) if self.sideways else 0.0

    @property
    def along(self) -> float:
        """Speed in the direction of travel (`direction`), in [m/s]; negative for driving straight back."""
        return math.hypot(self.speed, self.sideways) if self.sideways else self.speed

    @classmethod
    def towards(cls, direction: float, along: float, turn_rate: float) -> Self:
        """Return the command to drive in a direction of the base frame while turning.

        Args:
            direction: direction of travel, in [rad], counter-clockwise from straight ahead.
            along: speed in that direction, in [m/s].
            turn_rate: to the left, in [rad/s].
        """
        if direction == 0.0:
            return cls(along, turn_rate)
        return cls(along * math.cos(direction), turn_rate, along * math.sin(direction))


class Base(Capability):
    """Mobile base with wheels, commanded by speed and turn rate."""

    READINGS: ClassVar = {"wheel_travel": Reading("wheels")}
    COMMANDS = ("drive",)

    @abstractmethod
    def drive(self, speed: float, turn_rate: float) -> None:
        """Command the next period's forward speed in [m/s] and turn rate to the left in [rad/s].

        Raises:
            CommandError: a value is not finite or beyond the robot's limits.
        """

    @abstractmethod
    def wheel_travel(self) -> WheelTravel:
        """Return the distances in [m] that the wheels have rolled so far, by their encoders."""


class HolonomicBase(Base):
    """A base that drives in any direction: on mecanum or omni wheels, or on steered ones (swerve)."""

    @abstractmethod
    @override
    def drive(self, speed: float, turn_rate: float, sideways: float = 0.0) -> None:
        """Command the next period's motion.

        Args:
            speed: forward, in [m/s].
            turn_rate: to the left, in [rad/s].
            sideways: to the left, in [m/s].

        Raises:
            CommandError: a value is not finite or beyond the robot's limits.
        """
