"""The battery."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from .capability import Capability, Reading


class Battery(Capability):
    """The robot's battery, whose charge is measured."""

    READINGS: ClassVar = {"charge_percent": Reading("battery")}

    @abstractmethod
    def charge_percent(self) -> float:
        """Return the charge, 0 to 100, in [%]; NaN if it is not known."""
