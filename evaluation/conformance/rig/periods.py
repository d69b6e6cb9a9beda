"""Short sequences of commands that checks run on a backend."""

from __future__ import annotations

import numpy as np

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.robotics.numerics.arrays import FloatArray

from .numbers import as_numbers
from .parts import needed

SETTLING_PERIODS = 10  # periods within which a robot comes to rest
CHECK_SPEED = 0.3  # [rad/s], [m/s] at which checks move joints
CAR_SPEED = 0.2  # [m/s] at which a car turns
STEERING_PERIODS = 120  # periods within which it has steered from one side to the other and turned


def steps(backend: Backend, count: int) -> None:
    """Let `count` periods pass without a command."""
    for _ in range(count):
        backend.step()


def drive(backend: Backend, speed: float, turn_rate: float, periods: int, sideways: float = 0.0) -> None:
    """Drive with constant speeds, then wait until the base is at rest.

    Args:
        backend: backend of the base.
        speed: speed ahead, in [m/s].
        turn_rate: turn rate to the left, in [rad/s].
        periods: number of periods to drive.
        sideways: speed to the left, in [m/s], for a base that can move sideways.

    Raises:
        Skipped: the robot has no base.
    """
    base = needed(backend, Base)
    more = (sideways,) if sideways else ()
    for _ in range(periods):
        base.drive(speed, turn_rate, *more)
        backend.step()
    steps(backend, SETTLING_PERIODS)


def driven(backend: Backend, speed: float, turn_rate: float, periods: int) -> tuple[float, float]:
    """Drive with constant speeds, then stop, and return the left and the right wheel's travel, in [m].

    Args:
        backend: backend of the base.
        speed: speed ahead, in [m/s].
        turn_rate: turn rate to the left, in [rad/s].
        periods: number of periods to drive.
    """
    base = needed(backend, Base)
    before = base.wheel_travel()
    drive(backend, speed, turn_rate, periods)
    after = base.wheel_travel()
    return after.left - before.left, after.right - before.right


def drivable(spec: RobotFile, speed: float, turn_rate: float) -> tuple[float, float]:
    """Return the speed in [m/s] and the turn rate in [rad/s] that the base can drive.

    These are the wanted values, except for a car, which turns only while driving, and only as sharply as its
    steering allows.

    Args:
        spec: the robot's file.
        speed: wanted speed, in [m/s].
        turn_rate: wanted turn rate, in [rad/s].
    """
    if spec.drive.kind != "ackermann":
        return speed, turn_rate
    speed = speed or CAR_SPEED * (turn_rate != 0.0)
    most = 0.9 * spec.drive.sharpest_per_m * abs(speed)
    return speed, max(-most, min(turn_rate, most))


def beside(spec: RobotFile, joints: FloatArray, number: int, way: float) -> FloatArray:
    """Return a copy of a posture (n,) in which one joint is moved, in [rad] or [m].

    Args:
        spec: the robot's file.
        joints: (n,) joints of the posture, in [rad] or [m].
        number: index of the joint to move.
        way: change of the joint, in [rad] or [m]; its sign is reversed if the joint's limit is too near.
    """
    model, goal = spec.arm_model(), joints.copy()
    goal[number] += way
    if not model.within(goal):
        goal[number] -= 2.0 * way
    return goal


def move_joints(backend: Backend, arm: Arm, goal: FloatArray, speed: float = CHECK_SPEED) -> None:
    """Move the arm within its joints' speeds, and wait until it is at rest.

    Args:
        backend: backend of the arm.
        arm: arm to move.
        goal: (n,) joints, in [rad] or [m].
        speed: largest speed of a joint, in [rad/s] or [m/s].
    """
    start = arm.command()
    count = max(1, int(np.ceil(float(np.abs(goal - start).max()) / (speed * backend.period))))
    for share in np.linspace(0.0, 1.0, count + 1)[1:]:
        try:
            arm.move(start + share * (goal - start))
        except CommandError:
            if speed < CHECK_SPEED / 64:
                raise
            move_joints(backend, arm, goal, 0.5 * speed)
            return
        backend.step()
    steps(backend, SETTLING_PERIODS)


def all_readings(backend: Backend) -> dict[str, FloatArray]:
    """Return all readings of all capabilities in this period, each as numbers (n,) in its units.

    A reading is named by capability and method, such as "arm joints".
    """
    result: dict[str, FloatArray] = {}
    for part in backend.capabilities():
        for method, reading in part.READINGS.items():
            numbers = as_numbers(getattr(part, method)(), reading.measured)
            if numbers is not None:
                result[reading_name(part, method)] = numbers
    return result


def changing_readings(backend: Backend, periods: int) -> set[str]:
    """Return the names of the readings that change within a number of periods without commands."""
    first, changed = all_readings(backend), set[str]()
    for _ in range(periods):
        backend.step()
        now = all_readings(backend)
        changed |= {name for name in now if not np.array_equal(now[name], first[name], equal_nan=True)}
    return changed


def noisy_readings(backend: Backend) -> set[str]:
    """Return the names of the backend's sensor readings that are noisy on a real robot, such as "arm
    joints".
    """
    return {
        reading_name(part, method)
        for part in backend.capabilities()
        for method, reading in part.READINGS.items()
        if reading.noisy
    }


def reading_name(part: Capability, method: str) -> str:
    """Return the name of a reading for messages, made of capability and method, such as "arm joints"."""
    kind = next((capability for capability in all_capabilities() if isinstance(part, capability)), type(part))
    return f"{kind.words()} {method}"
