"""What a backend may be able to do."""

from __future__ import annotations

import re
from abc import ABC
from collections.abc import Mapping
from typing import ClassVar, NamedTuple


class Reading(NamedTuple):
    """What one method of a capability senses."""

    sensor: str
    """By which faults name it; two methods may be one sensor's."""
    measured: tuple[str, ...] = ()
    """Of a named tuple, the fields that are measured; none: all of its numbers."""
    noisy: bool = False
    """Whether at rest, too, each is another, within a few periods."""


class Capability(ABC):  # noqa: B024  what it can do is abstract in each kind
    """One thing that a robot can do or sense. A backend has those that its robot has.

    A command lives one period: it takes effect with the next step of the backend; not renewed, the base
    stops, and arm and gripper hold. A reading is taken once a period: asking again gives the same one.

    What stands around any backend (layers, faults, checks) follows from what a kind declares here.
    """

    READINGS: ClassVar[Mapping[str, Reading]] = {}
    """Its methods that sense; they take no arguments."""
    COMMANDS: ClassVar[tuple[str, ...]] = ()
    """Its methods that move something with the next step."""
    FILE_KEY: ClassVar[str | None] = None
    """Key of a robot's file that says whether the robot has one; None: each has."""

    @classmethod
    def words(cls) -> str:
        """What messages call it: `RangeSensor` is "range sensor"."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", cls.__name__).lower()
