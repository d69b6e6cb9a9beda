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
        """Command the joint values at the end of the next period, (n,) in [rad].

        Raises:
            CommandError: a value isn't finite, beyond its limit, or further than the joint's top speed
                takes it in one period.
        """

    @abstractmethod
    def command(self) -> NDArray[np.float64]:
        """The last commanded joint angles, (n,) in [rad], which the arm holds."""

    @abstractmethod
    def joints(self) -> NDArray[np.float64]:
        """Measured joint angles, (n,) in [rad]."""

    @abstractmethod
    def hand_force(self) -> NDArray[np.float64]:
        """The force that the surroundings put on the hand or the held object, (3,) in [N], in the hand frame.

        Measured by a wrist sensor or by the joints' efforts; the weight of the held object is subtracted.
        """
