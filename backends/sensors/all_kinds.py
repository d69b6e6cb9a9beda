"""All kinds of capabilities."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.sensors.sensor_kind import capability_of, sensor_capabilities

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile

ACTUATOR_CAPABILITIES: tuple[type[Capability], ...] = (Base, Arm, Gripper)


@cache
def all_capabilities() -> tuple[type[Capability], ...]:
    """Return all classes of capabilities that the conformance kit for backends tests: actuators, then
    sensors.
    """
    return (*ACTUATOR_CAPABILITIES, *sensor_capabilities())


def is_declared(kind: type[Capability], robot: RobotFile) -> bool:
    """Return True if a robot's file describes a capability of the class `kind`."""
    if kind in ACTUATOR_CAPABILITIES:
        return kind.FILE_KEY is None or getattr(robot, kind.FILE_KEY) is not None
    return any(capability_of(spec.kind) is kind for spec in robot.sensors.values())
