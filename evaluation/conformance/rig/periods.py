"""Short sequences of commands that checks run on a backend."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.capability import Capability, Reading
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.robotics.numerics.arrays import FloatArray

from .numbers import as_numbers
from .parts import needed

SETTLING_PERIODS = 10  # periods within which a robot comes to rest
CHECK_SPEED = 0.3  # [rad/s], [m/s] at which checks move joints
LIMIT_RATIO = 0.9  # of a limit that checks stay below
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

    These are the wanted values, or less for a robot whose limits are below them. A car turns only while
    driving, and only as sharply as its steering allows.

    Args:
        spec: the robot's file.
        speed: wanted speed, in [m/s].
        turn_rate: wanted turn rate, in [rad/s].
    """
    car = spec.drive.kind == "ackermann"
    if car and turn_rate:
        speed = speed or CAR_SPEED
    speed = _within(speed, spec.drive.top_speed_m_s)
    turn_rate = _within(turn_rate, math.radians(spec.drive.top_turn_deg_s))
    return speed, _within(turn_rate, spec.drive.sharpest_per_m * abs(speed)) if car else turn_rate


def sideways_speed(spec: RobotFile, speed: float) -> float:
    """Return the speed to the left in [m/s] that a base can drive: the wanted one, or less."""
    return _within(speed, spec.drive.top_sideways)


def _within(value: float, limit: float) -> float:
    """Return the value, or 90 % of the limit with its sign where that is less."""
    most = LIMIT_RATIO * limit
    return max(-most, min(value, most))


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

    A reading is named by capability and method, such as "arm joints", and where several sensors have that
    name, by the sensor's own as well. A sensor that measured nothing in this period has none.
    """
    result: dict[str, FloatArray] = {}
    for name, part, method, reading in _named_readings(backend):
        numbers = as_numbers(getattr(part, method)(), reading.measured)
        if numbers is not None:
            result[name] = numbers
    return result


def _named_readings(backend: Backend) -> Iterator[tuple[str, Capability, str, Reading]]:
    """Yield each reading of each capability: its name, the capability, the method, and its declaration."""
    names = Counter(reading_name(part, method) for part in backend.capabilities() for method in part.READINGS)
    for number, part in enumerate(backend.capabilities(), start=1):
        for method, reading in part.READINGS.items():
            name = reading_name(part, method)
            own = f" of {part.sensor_name or number}" if names[name] > 1 else ""
            yield f"{name}{own}", part, method, reading


def different_readings(first: Mapping[str, FloatArray], other: Mapping[str, FloatArray]) -> set[str]:
    """Return the names of the readings that differ, or that are there only once."""
    both = first.keys() & other.keys()
    unequal = {name for name in both if not np.array_equal(first[name], other[name], equal_nan=True)}
    return unequal | (first.keys() ^ other.keys())


def changing_readings(backend: Backend, periods: int) -> set[str]:
    """Return the names of the readings that change within a number of periods without commands."""
    first, changed = all_readings(backend), set[str]()
    for _ in range(periods):
        backend.step()
        changed |= different_readings(first, all_readings(backend))
    return changed


def noisy_readings(backend: Backend) -> set[str]:
    """Return the names of the backend's sensor readings that are noisy on a real robot, such as "arm
    joints".
    """
    return {name for name, _, _, reading in _named_readings(backend) if reading.noisy}


def reading_name(part: Capability, method: str) -> str:
    """Return the name of a reading for messages, made of capability and method, such as "arm joints"."""
    kind = next((capability for capability in all_capabilities() if isinstance(part, capability)), type(part))
    return f"{kind.words()} {method}"
