"""Motion of a book after the hand has released it."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.transform import inverse, transform

from .book import SimulatedBook
from .book_lean import lean_in_row
from .books_there import BooksThere
from .row import FreeInterval, members, slots
from .shelf import SHELF_DEPTH_M, SimulatedShelf

HIGHEST_DROP = 0.020  # onto a support; from higher up a book falls over and off [m]
_BELOW = 0.003


def put_down(books: BooksThere, book: SimulatedBook, slot: FreeInterval | None, aside: float = 0.0) -> None:
    """Let a book drop from its current pose, as when the fingers open; set its new pose and support.

    If a shelf's board or the tray is below the book's middle, at most 20 mm below the lower edge of its spine
    (its foot), the book rests on it: on the board in its slot, leaning as far as its neighbours allow; on the
    tray upright. Otherwise it falls to the floor, or flat onto the board, and is lost to the robot.

    Args:
        books: books and shelves of the scene.
        book: book to drop.
        slot: slot that the book was in; None if it was not in a slot.
        aside: angle at which the fingers leave the book leaning, in [rad], positive to the left.
    """
    scene = books.scene
    scene.changes += 1
    shelf = next((s for s in books.shelves.values() if _carries(books, s, book, slot)), None)
    if shelf is not None:
        held = shelf.inverse_pose @ book.pose
        foot = transform((float(held[0, 3]), float(held[1, 3]), 0.0))
        wish = aside - math.atan2(held[2, 1], held[2, 2])
        leans = lean_in_row(book, foot, members(books, shelf, book), wish)
        if leans is None:
            _fall(book, float(shelf.pose[2, 3]))
            return
        book.pose, book.rest, book.shelf = shelf.pose @ leans, Rest.TABLE, shelf.name
    elif _on_tray(books, book):
        base_T_book = inverse(scene.world_T_base) @ book.pose
        yaw = float(np.arctan2(base_T_book[1, 0], base_T_book[0, 0]))
        x, y = base_T_book[:2, 3]
        book.base_T_thing = transform((float(x), float(y), scene.robot.tray_shape.top), (0.0, 0.0, yaw))
        book.pose, book.rest = scene.world_T_base @ book.base_T_thing, Rest.TRAY
    else:
        _fall(book)


def _carries(
    books: BooksThere, shelf: SimulatedShelf, book: SimulatedBook, slot: FreeInterval | None
) -> bool:
    pose = shelf.inverse_pose @ book.pose
    x, y, z = pose[:3, 3]
    middle = x + pose[0, 0] * book.depth / 2
    if not (0.0 < middle < SHELF_DEPTH_M and -_BELOW < z < HIGHEST_DROP and pose[0, 0] > 0.9):
        return False
    half = book.thickness / 2 - 1e-4
    free = [slot] if slot is not None else slots(members(books, shelf, book))
    return any(item.right <= y - half and y + half <= item.left for item in free)


def _on_tray(books: BooksThere, book: SimulatedBook) -> bool:
    scene = books.scene
    if books.tray_book() is not None or not scene.robot.has_tray:
        return False
    tray = scene.robot.tray_shape
    foot = inverse(scene.world_T_base) @ book.pose
    middle = foot @ np.array([book.depth / 2, 0.0, 0.0, 1.0])
    near = all(abs(middle[i] - tray.middle[i]) < tray.size[i] / 2 for i in range(2))
    return near and -_BELOW < middle[2] - tray.top < HIGHEST_DROP and foot[2, 2] > 0.98


def _fall(book: SimulatedBook, height: float = 0.0) -> None:
    """Lay the book on its cover below the place where it was released, on a support `height` [m] above the
    floor.
    """
    x, y = book.pose[:2, 3]
    yaw = float(np.arctan2(book.pose[1, 0], book.pose[0, 0]))
    lying = transform((float(x), float(y), height + book.thickness / 2), (np.pi / 2, 0.0, yaw))
    book.pose, book.rest, book.shelf = lying, Rest.FLOOR, None
