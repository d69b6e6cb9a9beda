"""Base class of everything that a backend may be able to do."""

from __future__ import annotations

import re
from abc import ABC
from collections.abc import Mapping
from typing import ClassVar, NamedTuple


class Reading(NamedTuple):
    """Declaration of a method that senses."""

    sensor: str
    """Name of the sensor in faults; two methods may share one sensor."""
    measured: tuple[str, ...] = ()
    """Fields of a named tuple that are measured; empty: all of its numbers."""
    noisy: bool = False
    """True if readings differ within a few periods even at rest."""


class Capability(ABC):  # noqa: B024  what it can do is abstract in each kind
    """One thing that a robot can do or sense. A backend has the capabilities of its robot.

    A command lives one period: it takes effect with the next step of the backend. If it is not renewed,
    the base stops, and arm and gripper hold. A reading is taken once a period: asking again returns the
    same one.

    Everything that wraps a backend (layers, faults, checks) uses the declarations of each kind.
    """

    READINGS: ClassVar[Mapping[str, Reading]] = {}
    """Its methods that sense; they take no arguments."""
    COMMANDS: ClassVar[tuple[str, ...]] = ()
    """Its methods that move something with the next step."""
    FILE_KEY: ClassVar[str | None] = None
    """Key of a robot's file that says whether the robot has one; None: each has."""

    @classmethod
    def words(cls) -> str:
        """Return the name used in messages: `RangeSensor` is "range sensor"."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", cls.__name__).lower()
