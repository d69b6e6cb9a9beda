"""A rung of the ladder by which a robot is brought up."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from handcart.files.errors import HandcartError

from .site import Site

Facts = dict[str, Any]


class RungFailed(HandcartError):
    """What was to be shown isn't so; told with what to look at."""


class Rung(ABC):
    """Shows one thing about a robot. It has shown it when `climb` returns."""

    name: ClassVar[str]
    """How its record is called."""
    summary: ClassVar[str]
    """What is shown, in one line."""
    moves: ClassVar[bool] = True
    """Whether the robot moves meanwhile."""

    @abstractmethod
    def climb(self, site: Site) -> Facts:
        """Show it.

        Raises:
            RungFailed: it isn't so.
            RobotFault: the robot has stopped by itself.
        """

    def left_out(self, site: Site) -> str:
        """Why this robot has no such thing to show; "" where it has."""
        return ""
