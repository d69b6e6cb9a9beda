"""How the hand holds a book: by the rear of its covers, beside the spine."""

from __future__ import annotations

from handcart.backends.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.contract.discrepancy import Discrepancy, Measured
from handcart.primitives.knowledge.place import Book

BITE = 0.03  # [m] of the book's rear that the pads cover
GRIP_HEIGHT = 0.12  # [m] from the book's foot to the hand
PATIENCE = 3.0  # [s] that the fingers get
THICKNESS_ERROR = 0.004  # [m] by which a book may differ from its entry in the catalogue
ARRIVED = 0.0005  # [m]
NOTHING = 2.0  # [mm] between the pads: less is no book


def hand_to_tips(robot: Robot) -> float:
    """From the frame `hand` to the finger tips, in [m]."""
    return robot.spec.finger_shape.tip


def hand_to_spine(robot: Robot) -> float:
    """From the frame `hand` to the spine of a book that it holds, in [m]."""
    return hand_to_tips(robot) - BITE


def open_to(robot: Robot, width: float | None = None) -> Periods:
    """Open the fingers to `width` in [m], None: fully, and wait until they stand there."""
    spec = robot.spec.gripper
    most = spec.opening_mm / 1e3 if spec is not None else 0.0
    goal = most if width is None else min(width, most)
    robot.gripper.move(goal)
    end = robot.time + PATIENCE
    while abs(robot.gripper.width() - goal) > ARRIVED:
        if robot.time > end:
            wide = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), 1e3 * goal, "mm")
            raise Discrepancy("the fingers don't open", measured=wide)
        yield


def close(robot: Robot) -> Periods:
    """Close the fingers until they press on something, which may be each other."""
    robot.gripper.move(0.0)
    end = robot.time + PATIENCE
    yield
    while not robot.gripper.closed_on_something():
        if robot.time > end:
            raise Discrepancy("the fingers don't close", measured=opening(robot, None))
        yield


def holds(robot: Robot, book: Book) -> bool:
    """Whether the fingers press on something as thick as that book."""
    off = abs(robot.gripper.width() - book.thickness_mm / 1e3)
    return robot.gripper.closed_on_something() and off < THICKNESS_ERROR


def opening(robot: Robot, book: Book | None) -> Measured:
    """What the gripper reads, for a Discrepancy: how far from a book's thickness, or the width alone."""
    width = 1e3 * robot.gripper.width()
    if book is None or not robot.gripper.closed_on_something():
        return Measured("Gripper", "the fingers press on nothing; opening", width, unit="mm")
    off = abs(width - book.thickness_mm)
    return Measured("Gripper", "opening off the book's thickness", off, 1e3 * THICKNESS_ERROR, "mm")


def close_on(robot: Robot, book: Book) -> Periods:
    """Close the fingers on a book.

    Raises:
        Discrepancy: there is nothing between them, or something of another thickness.
    """
    yield from close(robot)
    width = 1e3 * robot.gripper.width()
    if width < NOTHING:
        raise Discrepancy(
            "the fingers closed on nothing", measured=Measured("Gripper", "opening", width, NOTHING, "mm")
        )
    if not holds(robot, book):
        raise Discrepancy(
            f"what the fingers hold is {width:.0f} mm thick, not {book.thickness_mm:.0f}",
            measured=opening(robot, book),
        )
