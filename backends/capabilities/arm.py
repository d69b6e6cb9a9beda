"""The arm."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from .capability import Capability, Reading


class Arm(Capability):
    """An arm under position control, joints in the order of the robot's file."""

    READINGS: ClassVar = {"joints": Reading("joints"), "hand_force": Reading("force")}
    COMMANDS = ("move",)
    FILE_KEY = "arm"

    @abstractmethod
    def move(self, joints: NDArray[np.float64]) -> None:
        """Command the joint angles at the end of the next period, (n,) in [rad].

        Raises:
            CommandError: a value is not finite, is beyond its limit, or needs more than the joint's top
                speed for one period.
        """

    @abstractmethod
    def command(self) -> NDArray[np.float64]:
        """Return the last commanded joint angles, (n,) in [rad], which the arm holds."""

    @abstractmethod
    def joints(self) -> NDArray[np.float64]:
        """Measured joint angles, (n,) in [rad]."""

    @abstractmethod
    def hand_force(self) -> NDArray[np.float64]:
        """Return the force of the surroundings on the hand or its object, (3,) in [N], in the hand frame.

        It comes from a wrist sensor or from the joints' efforts; the weight of the held object is
        subtracted.
        """
