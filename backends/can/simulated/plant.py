"""Loads that simulated drives turn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from typing_extensions import override

from .drive_node import DriveNode


class Plant(ABC):
    """Interface of a simulated mechanical load that the motors of simulated drives move."""

    @abstractmethod
    def step(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        """Move all motors for a time towards their commanded positions, and report the reached ones to the
        drives.

        The commands are `drive.driven`; `drive.moved` receives the positions.

        Args:
            drives: drives by node ID.
            seconds: duration, in [s].
        """


class IdealMotors(Plant):
    """Motors without load, which are always exactly at their set-points."""

    @override
    def step(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        for drive in drives.values():
            drive.moved(drive.driven, seconds, torque=0)
