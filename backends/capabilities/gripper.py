"""The gripper."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from .capability import Capability, Reading


class Gripper(Capability):
    """Two fingers that close along the hand's y axis until they meet each other or an object."""

    READINGS: ClassVar = {"width": Reading("width"), "closed_on_something": Reading("width")}
    COMMANDS = ("move",)
    FILE_KEY = "gripper"

    @abstractmethod
    def command(self) -> float:
        """Return the last commanded width, in [m]."""

    @abstractmethod
    def move(self, width: float) -> None:
        """Command the opening between the finger pads, in [m]. Fingers that meet an object stop there and
        hold it.

        Raises:
            CommandError: the width is not finite or not between 0 and the gripper's opening.
        """

    @abstractmethod
    def width(self) -> float:
        """Measured opening between the finger pads, in [m]."""

    @abstractmethod
    def closed_on_something(self) -> bool:
        """Return True if the fingers press on an object or on each other, by the gripper's own measurements,
        such as motor current.
        """
