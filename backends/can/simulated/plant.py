"""What simulated drives turn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from typing_extensions import override

from .drive_node import DriveNode


class Plant(ABC):
    """What moves when motors are driven."""

    @abstractmethod
    def step(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        """Let a period in [s] pass in which each motor is driven to `drive.driven`; tell each where it is."""


class IdealMotors(Plant):
    """Motors without load, which stand exactly where they are driven to."""

    @override
    def step(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        for drive in drives.values():
            drive.moved(drive.driven, seconds, torque=0)
