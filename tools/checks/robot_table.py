"""Table of robots: which backends take each, and which primitives its sensors and drives allow there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.camera import HAND_LINK, AnyCamera, Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_names import named_robots
from handcart.backends.description.sensor_spec import SensorSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import backend_class, backend_names
from handcart.backends.sensors.sensor_kind import capability_of
from handcart.files.errors import InputError
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.registry import primitive_class, primitive_names
from handcart.robotics.kinematics.urdf_mounts import joints_between

SECTIONS = {"can": "can", "ros2": "ros2"}
"""Sections of a robot's file that a backend needs."""


class RobotRow(NamedTuple):
    """Row of the table of robots, with a robot's backends and the primitives that it can do."""

    robot: str
    backends: tuple[str, ...]
    primitives: tuple[str, ...]
    """Primitives whose needs the robot has; the same on all its backends."""
    wrong: str = ""
    """Why the robot cannot be read, such as a package that is not installed."""

    def line(self, wide: int) -> str:
        """Return the row as text: the robot's name, its backends and primitives, or why it cannot be read.

        Args:
            wide: width of the column of names, in characters.
        """
        rest = self.wrong or f"{', '.join(self.backends)}: {', '.join(self.primitives)}"
        return f"{self.robot:<{wide}}  {rest}"


def robot_table(robots: dict[str, Path] | None = None) -> Iterator[RobotRow]:
    """Yield a row for each shipped or installed robot, with the backends and primitives that can be used with
    it.

    The primitives are those for which the robot has the sensors, drives and sections of its file. Whether its
    tray, tool or postures are right for a task is checked with the task.

    Args:
        robots: files by names (default: all shipped and installed robots).
    """
    backends = {name: found for name in backend_names() if (found := _class_of(name)) is not None}
    primitives = {name: kind for name in primitive_names() if (kind := _primitive(name)) is not None}
    for name, path in (named_robots() if robots is None else robots).items():
        try:
            robot = load_robot(str(path), drives=False)
        except InputError as error:
            yield RobotRow(name, (), (), _short(str(error)))
            continue
        kinds = list(kinds_of(robot))
        able = tuple(key for key, kind in primitives.items() if _has_all(kinds, kind.needs))
        yield RobotRow(name, tuple(key for key, kind in backends.items() if _takes(key, kind, robot)), able)


def kinds_of(robot: RobotFile) -> Iterator[type[Capability]]:
    """Yield the capabilities that a robot has according to its file.

    A camera on the hand is a `Camera`, any other one an `AnyCamera`.
    """
    yield Base
    if robot.arm is not None:
        yield Arm
    if robot.gripper is not None:
        yield Gripper
    for spec in robot.sensors.values():
        kind = capability_of(spec.kind)
        yield kind if not issubclass(kind, Camera) or _is_on_hand(robot, spec) else AnyCamera


def _is_on_hand(robot: RobotFile, spec: SensorSpec) -> bool:
    """Return whether a sensor is fixed on the hand of an arm."""
    return robot.arm is not None and not joints_between(robot.urdf_text(), robot.link_of(spec), HAND_LINK)


def _has_all(kinds: Iterable[type[Capability]], needs: Iterable[type[Capability]]) -> bool:
    have = tuple(kinds)
    return all(any(issubclass(kind, need) for kind in have) for need in needs)


def _takes(name: str, backend: type[Backend], robot: RobotFile) -> bool:
    """Return whether a backend can drive a robot: its kind of drive, and the section that it needs."""
    section = SECTIONS.get(name)
    stated = section is None or getattr(robot, section) is not None
    return stated and robot.drive.kind in backend.drive_kinds


def _class_of(name: str) -> type[Backend] | None:
    """Return a backend's class; None if its library is not installed."""
    try:
        return backend_class(name)
    except InputError:
        return None


def _primitive(name: str) -> type[ActionPrimitive] | None:
    try:
        return primitive_class(name)
    except (ImportError, AttributeError):
        return None


def _short(error: str) -> str:
    """Return the remedy for a missing package, or the first line of another error."""
    head, install, command = error.partition("pip install ")
    return f"needs: {install}{command}" if install else head.splitlines()[0]
