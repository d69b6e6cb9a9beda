"""The parts of a robot that the kit knows, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from handcart.backends.arm import Arm
from handcart.backends.backend import Backend
from handcart.backends.base import Base
from handcart.backends.camera import Camera
from handcart.backends.gripper import Gripper
from handcart.backends.positioning import Positioning
from handcart.backends.range_sensor import RangeSensor

from .skipped import Skipped

P = TypeVar("P")


@dataclass
class Parts:
    """What a backend has; None where the robot has none."""

    base: Base | None = None
    arm: Arm | None = None
    gripper: Gripper | None = None
    camera: Camera | None = None
    range_sensor: RangeSensor | None = None
    positioning: Positioning | None = None


def parts_of(backend: Backend) -> Parts:
    """Sort a backend's capabilities; those that the kit doesn't know are left out."""
    found = Parts()
    for part in backend.capabilities():
        match part:
            case Base():
                found.base = part
            case Arm():
                found.arm = part
            case Gripper():
                found.gripper = part
            case Camera():
                found.camera = part
            case RangeSensor():
                found.range_sensor = part
            case Positioning():
                found.positioning = part
    return found


def needed(part: P | None, name: str) -> P:
    """The part; raises `Skipped` where the robot has none."""
    if part is None:
        raise Skipped(f"the robot has no {name}")
    return part


def base_of(backend: Backend) -> Base:
    """The wheels."""
    return needed(parts_of(backend).base, "base")


def arm_of(backend: Backend) -> Arm:
    """The arm; raises `Skipped` where the robot has none."""
    return needed(parts_of(backend).arm, "arm")


def gripper_of(backend: Backend) -> Gripper:
    """The gripper; raises `Skipped` where the robot has none."""
    return needed(parts_of(backend).gripper, "gripper")


def camera_of(backend: Backend) -> Camera:
    """The camera; raises `Skipped` where the robot has none."""
    return needed(parts_of(backend).camera, "camera")


def range_sensor_of(backend: Backend) -> RangeSensor:
    """The range sensor; raises `Skipped` where the robot has none."""
    return needed(parts_of(backend).range_sensor, "range sensor")


def positioning_of(backend: Backend) -> Positioning:
    """The indoor positioning; raises `Skipped` where the robot has none."""
    return needed(parts_of(backend).positioning, "positioning")
