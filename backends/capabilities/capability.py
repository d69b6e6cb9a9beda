"""Base class of the capabilities of a backend."""

from __future__ import annotations

import re
from abc import ABC
from collections.abc import Mapping
from typing import ClassVar, NamedTuple


class Reading(NamedTuple):
    """Description of a method that reads a sensor, such as `Arm.joints`.

    It determines how readings are recorded and how faults of the sensor are simulated.
    """

    sensor: str
    """Name of the sensor in faults; two methods may belong to one sensor."""
    measured: tuple[str, ...] = ()
    """Measured fields of a named tuple; empty: all of its numbers."""
    noisy: bool = False
    """True if readings differ within a few periods even at rest."""


class Capability(ABC):  # noqa: B024  what it can do is abstract in each kind
    """Base class of the kinds of actuators and sensors, such as `Arm` or `Camera`.

    A backend provides an object for each actuator and sensor of its robot.
    """

    READINGS: ClassVar[Mapping[str, Reading]] = {}
    """Methods that read a sensor, without arguments, by name."""
    COMMANDS: ClassVar[tuple[str, ...]] = ()
    """Names of the methods that move something with the next step."""
    FILE_KEY: ClassVar[str | None] = None
    """Section of a robot's file that says whether the robot has such an actuator; None: each has. Sensors
    are in the table `sensors`.
    """
    sensor_name: str = ""
    """Name of a sensor in the robot's file; "" for an actuator, and for the only sensor of its kind if a
    backend does not set it.
    """

    @classmethod
    def words(cls) -> str:
        """Return the name of the capability for messages, such as "range sensor" for `RangeSensor`."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", cls.__name__).lower()
