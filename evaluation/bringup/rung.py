"""Step of the procedure by which a robot is brought up."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, TypeVar

from handcart.files.errors import HandcartError

from .site import RobotSite

SiteT = TypeVar("SiteT", bound=RobotSite)

Facts = dict[str, Any]


class RungFailed(HandcartError):
    """Error for a bring-up step that failed; the message says what to check."""


class Rung(ABC, Generic[SiteT]):
    """Base class of bring-up steps, each of which verifies one property of a robot.

    A step has passed if `climb` returns without `RungFailed`.
    """

    name: ClassVar[str]
    """Name of the step, and of its record."""
    summary: ClassVar[str]
    """Verified property, in one line."""
    moves: ClassVar[bool] = True
    """True if the robot moves during the step."""

    @abstractmethod
    def climb(self, site: SiteT) -> Facts:
        """Carry out the step on a robot or bench; return the measured facts.

        Raises:
            RungFailed: the step is not passed.
        """

    def left_out(self, site: SiteT) -> str:
        """Return the reason why this step does not apply to the robot; empty if the step applies."""
        return ""
