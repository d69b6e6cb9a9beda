"""Opening and closing the fingers."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds

GRIP_TIMEOUT_S = 3.0  # that the fingers get
OPENING_TOLERANCE_M = 0.0005


def hand_to_tips(robot: Robot) -> float:
    """Return the distance from the frame `hand` to the finger tips, in [m]."""
    return robot.spec.finger_shape.tip


def open_to(robot: Robot, width: float | None = None) -> Periods:
    """Open the fingers, and wait until they are there.

    Args:
        robot: robot with a gripper.
        width: wanted opening between the pads, in [m]; None: the largest.

    Raises:
        Discrepancy: the fingers don't reach the opening.
    """
    spec = robot.spec.gripper
    most = spec.opening_mm / 1e3 if spec is not None else 0.0
    goal = most if width is None else min(width, most)
    robot.gripper.move(goal)
    end = robot.time + GRIP_TIMEOUT_S
    while exceeds(abs(robot.gripper.width() - goal), OPENING_TOLERANCE_M):
        if robot.time > end:
            wide = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), 1e3 * goal, "mm")
            raise Discrepancy("the fingers don't open", measured=wide, cause=causes.FINGERS_STUCK)
        yield


def close(robot: Robot) -> Periods:
    """Close the fingers until they press on something, which may be each other.

    Raises:
        Discrepancy: the fingers do not press on anything within `GRIP_TIMEOUT_S`.
    """
    robot.gripper.move(0.0)
    end = robot.time + GRIP_TIMEOUT_S
    yield
    while not robot.gripper.closed_on_something():
        if robot.time > end:
            raise Discrepancy(
                "the fingers don't close", measured=width_read(robot), cause=causes.FINGERS_STUCK
            )
        yield


def width_read(robot: Robot) -> Measured:
    """Return the measured opening of fingers that press on nothing, in the form in which a `Discrepancy`
    reports a reading.
    """
    return Measured(
        "Gripper", "the fingers press on nothing; opening", 1e3 * robot.gripper.width(), unit="mm"
    )


def holds(robot: Robot, width: float, most: float) -> bool:
    """Return whether the fingers press on an object of that width, within `most`, both in [m]."""
    return robot.gripper.closed_on_something() and abs(robot.gripper.width() - width) < most


def width_off(robot: Robot, width: float, most: float, what: str) -> Measured:
    """Return the difference between the fingers' measured opening and an expected one, as reported in a
    `Discrepancy`.

    Args:
        robot: robot with a gripper.
        width: expected opening, in [m].
        most: largest allowed difference, in [m].
        what: name of the expected opening in the report.
    """
    off = 1e3 * abs(robot.gripper.width() - width)
    return Measured("Gripper", f"opening off {what}", off, 1e3 * most, "mm")
