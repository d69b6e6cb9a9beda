"""Small scripts that checks let a backend run through."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.arm import Arm
from handcart.backends.backend import Backend

from .parts import base_of, parts_of

SETTLES = 10  # periods within which a robot comes to rest
SLOW = 0.3  # [rad/s] at which checks move joints


def steps(backend: Backend, count: int) -> None:
    """Let periods pass without a command."""
    for _ in range(count):
        backend.step()


def drive(backend: Backend, speed: float, turn_rate: float, periods: int) -> None:
    """Drive for so many periods, then wait until it stands."""
    base = base_of(backend)
    for _ in range(periods):
        base.drive(speed, turn_rate)
        backend.step()
    steps(backend, SETTLES)


def driven(backend: Backend, speed: float, turn_rate: float, periods: int) -> tuple[float, float]:
    """The same; gives how far the left and the right wheel rolled, in [m]."""
    base = base_of(backend)
    before = base.wheel_travel()
    drive(backend, speed, turn_rate, periods)
    after = base.wheel_travel()
    return after.left - before.left, after.right - before.right


def move_joints(backend: Backend, arm: Arm, goal: NDArray[np.float64]) -> None:
    """Move slowly to joint angles (n,) in [rad], and wait until they stand."""
    start = arm.command()
    count = max(1, int(np.ceil(float(np.abs(goal - start).max()) / (SLOW * backend.period))))
    for share in np.linspace(0.0, 1.0, count + 1)[1:]:
        arm.move(start + share * (goal - start))
        backend.step()
    steps(backend, SETTLES)


def all_readings(backend: Backend) -> dict[str, NDArray[np.float64]]:
    """Every reading of this period, by name."""
    parts = parts_of(backend)
    result: dict[str, NDArray[np.float64]] = {}
    if parts.base is not None:
        result["wheels"] = np.array(list(parts.base.wheel_travel()))
    if parts.arm is not None:
        result |= {"joints": parts.arm.joints(), "force": parts.arm.hand_force()}
    if parts.gripper is not None:
        result["width"] = np.array([parts.gripper.width(), parts.gripper.closed_on_something()])
    if parts.camera is not None:
        result["image"] = parts.camera.image().astype(np.float64)
    if parts.range_sensor is not None:
        result["scan"] = parts.range_sensor.scan().ranges.copy()
    told = None if parts.positioning is None else parts.positioning.reading()
    if told is not None:
        result["positioning"] = np.array([told.number, *told.pose])
    return result
