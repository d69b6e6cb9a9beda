"""Motion of a drive in a mode of operation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

from handcart.backends.can.drives.profile import ramp

from .drive_objects import DriveObjects

TARGET_REACHED, SETPOINT_TAKEN = 1 << 10, 1 << 12
"""Bits of the statusword (6041h); in homing the second says that it is done."""
NEW_SETPOINT, AT_ONCE, RELATIVE = 1 << 4, 1 << 5, 1 << 6
"""Bits of the controlword (6040h)."""


@dataclass
class Demand:
    """Set-points of position and velocity for a simulated drive's motor, which the drive plans in each
    period.
    """

    position: float = 0.0
    """Position of the motor, in [counts]; homing does not change it."""
    velocity: float = 0.0
    """Velocity of the motor, in [counts/s]."""
    home: float = 0.0
    """Offset between the motor's position and the reported one (6064h) [counts]."""
    switch: float = field(default=-50_000.0)
    """Below this position of the motor the negative limit switch is pressed, in [counts]."""

    def brake(self, rate: float, seconds: float) -> None:
        """Advance the motor's set-points by `seconds`, at constant deceleration until they rest.

        Args:
            rate: deceleration, in [counts/s²].
            seconds: duration of the advance, in [s].
        """
        way, self.velocity = ramp(self.velocity, 0.0, rate, seconds)
        self.position += way


class DriveMode(ABC):
    """Base class of a simulated drive's modes of operation (6060h), which plan the motor's set-points."""

    def __init__(self, objects: DriveObjects, demand: Demand) -> None:
        self.objects, self.demand = objects, demand

    def begin(self) -> None:
        """Start the mode, when the drive is enabled in it or changes to it: hold the present position."""
        return

    def control(self, controlword: int, rising: int) -> None:
        """React to a received controlword (6040h), for example by accepting a new set-point.

        Args:
            controlword: the received word.
            rising: bits of `controlword` that were not set in the word before.
        """
        return

    def latch(self) -> None:
        """Apply the set-points that were received before a SYNC; called at each SYNC."""
        return

    @abstractmethod
    def advance(self, seconds: float) -> None:
        """Advance the motor's set-points by `seconds` [s], while the drive is in OPERATION ENABLED."""

    @property
    def status(self) -> int:
        """Bits of the statusword (6041h) that the mode sets."""
        return 0

    @property
    def position_loop(self) -> bool:
        """True if the drive supervises its following error in this mode."""
        return True
