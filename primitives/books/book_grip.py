"""Grip of a book: on the rear of its covers, next to the spine."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions import grip
from handcart.primitives.motions.grip import close, hand_to_tips, width_read
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured

from .books import Books
from .catalogue import Book, name_of_book

BOOK_GRIP_DEPTH_M = 0.03  # of the book's rear that the pads cover
GRIP_HEIGHT = 0.12  # [m] from the book's foot to the hand
THICKNESS_ERROR = 0.004  # [m] by which a book may differ from its entry in the catalogue
MIN_BOOK_WIDTH_MM = 2.0  # between the pads: a smaller gap means no book


def hand_to_spine(robot: Robot) -> float:
    """Return the distance from the frame `hand` to the spine of a held book, in [m]."""
    return hand_to_tips(robot) - BOOK_GRIP_DEPTH_M


def holds(robot: Robot, book: Book) -> bool:
    """Return whether the fingers hold an object as thick as the given book."""
    return grip.holds(robot, book.thickness_mm / 1e3, THICKNESS_ERROR)


def book_in(model: ModelView) -> str:
    """Return the name, in simulated worlds, of the recognized book; empty if no book was recognized."""
    book = model.of(Books).book
    return "" if book is None else name_of_book(book)


def unlike_book(robot: Robot, model: ModelView) -> str:
    """Return why the held object cannot be the book that was recognized before; empty if it may be that
    book.
    """
    book = model.of(Books).book
    if book is None:
        return "no book has been recognized"
    if holds(robot, book):
        return ""
    width = 1e3 * robot.gripper.width()
    return (
        f"the hand does not hold {name_of_book(book)}: what it holds is {width:.1f} mm thick, "
        f"not {book.thickness_mm:.1f} mm"
    )


def opening(robot: Robot, book: Book | None) -> Measured:
    """Return the difference of the fingers' opening from the book's thickness, to be put in a `Discrepancy`.

    If no book is known, or nothing is between the fingers, the opening itself is returned.
    """
    if book is None or not robot.gripper.closed_on_something():
        return width_read(robot)
    off = abs(1e3 * robot.gripper.width() - book.thickness_mm)
    return Measured("Gripper", "opening off the book's thickness", off, 1e3 * THICKNESS_ERROR, "mm")


def watch_grip(robot: Robot, book: Book | None) -> None:
    """Raise `Discrepancy` if the hand no longer holds a book; `book` is the expected one, if known."""
    if not robot.gripper.closed_on_something():
        raise Discrepancy(
            "the book slipped out of the hand", measured=opening(robot, book), cause=causes.SLIPPED
        )


def close_on(robot: Robot, book: Book) -> Periods:
    """Close the fingers on a book.

    Raises:
        Discrepancy: between the fingers is nothing, or an object of another thickness than the book's.
    """
    yield from close(robot)
    width = 1e3 * robot.gripper.width()
    if width < MIN_BOOK_WIDTH_MM:
        raise Discrepancy(
            "the fingers closed on nothing",
            measured=Measured("Gripper", "opening", width, MIN_BOOK_WIDTH_MM, "mm"),
            cause=causes.NOT_HELD,
        )
    if not holds(robot, book):
        raise Discrepancy(
            f"the held object is {width:.0f} mm thick, not {book.thickness_mm:.0f}",
            measured=opening(robot, book),
            cause=causes.NOT_HELD,
        )
