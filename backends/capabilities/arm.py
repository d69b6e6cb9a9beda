"""The arm."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from handcart.robotics.numerics.arrays import FloatArray

from .capability import Capability, Reading


class Arm(Capability):
    """An arm under position control, joints in the order of the robot's file."""

    READINGS: ClassVar = {"joints": Reading("joints"), "hand_force": Reading("force")}
    COMMANDS = ("move",)
    FILE_KEY = "arm"

    @abstractmethod
    def move(self, joints: FloatArray) -> None:
        """Command the joint positions (n,) for the end of the next period, in [rad], or [m] for sliding
        joints.

        Raises:
            CommandError: a value is not finite, is beyond its limit, or needs more than the joint's top speed
                for one period.
        """

    @abstractmethod
    def command(self) -> FloatArray:
        """Return the last commanded joints (n,), in [rad] or [m], which the arm holds."""

    @abstractmethod
    def joints(self) -> FloatArray:
        """Return the measured joints (n,), in [rad] or [m]."""

    @abstractmethod
    def hand_force(self) -> FloatArray:
        """Return the force of the surroundings on the hand or its object, (3,) in [N], in the hand frame.

        The force comes from a wrist sensor or from the joints' efforts; it is zero if the arm measures
        neither. The weight of the arm is subtracted from it, the weight of a held object is not.
        """


class ForceArm(Arm):
    """An arm that measures the force on its hand, by a wrist sensor or by its joints' efforts."""
