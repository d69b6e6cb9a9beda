"""How the hand holds a book: by the rear of its covers, beside the spine."""

from __future__ import annotations

from backends.robot import Robot

from .action_primitive import Periods
from .discrepancy import Discrepancy
from .knowledge import Book

HAND_TO_SPINE = 0.12  # [m] from the hand to the spine: the pads cover the book's rear 30 mm
HAND_TO_TIPS = 0.15  # [m]
GRIP_HEIGHT = 0.12  # [m] from the book's foot to the hand
PATIENCE = 3.0  # [s] that the fingers get
THICKNESS_ERROR = 0.004  # [m] by which a book may differ from its entry in the catalogue
ARRIVED = 0.0005  # [m]


def open_to(robot: Robot, width: float | None = None) -> Periods:
    """Open the fingers to `width` in [m], None: fully, and wait until they stand there."""
    spec = robot.spec.gripper
    most = spec.opening_mm / 1e3 if spec is not None else 0.0
    goal = most if width is None else min(width, most)
    robot.gripper.move(goal)
    end = robot.time + PATIENCE
    while abs(robot.gripper.width() - goal) > ARRIVED:
        if robot.time > end:
            raise Discrepancy("the fingers don't open")
        yield


def close(robot: Robot) -> Periods:
    """Close the fingers until they press on something, which may be each other."""
    robot.gripper.move(0.0)
    end = robot.time + PATIENCE
    yield
    while not robot.gripper.closed_on_something():
        if robot.time > end:
            raise Discrepancy("the fingers don't close")
        yield


def holds(robot: Robot, book: Book) -> bool:
    """Whether the fingers press on something as thick as that book."""
    off = abs(robot.gripper.width() - book.thickness_mm / 1e3)
    return robot.gripper.closed_on_something() and off < THICKNESS_ERROR


def close_on(robot: Robot, book: Book) -> Periods:
    """Close the fingers on a book.

    Raises:
        Discrepancy: there is nothing between them, or something of another thickness.
    """
    yield from close(robot)
    width = 1e3 * robot.gripper.width()
    if width < 2.0:
        raise Discrepancy("the fingers closed on nothing")
    if not holds(robot, book):
        raise Discrepancy(f"what the fingers hold is {width:.0f} mm thick, not {book.thickness_mm:.0f}")
