"""Support of a book in physics."""

from __future__ import annotations

import numpy as np

from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.transform import inverse

from .book import SimulatedBook
from .books_there import BooksThere
from .shelf import SHELF_DEPTH_M

MAX_FOOT_GAP_M = 0.03  # [m] that a book's foot may be off the board or tray
MAX_TRAY_OFFSET_M = 0.01  # [m] that its middle may be beside the tray
MAX_UPRIGHT_TILT_RAD = np.radians(45.0)
MAX_FALLEN_HEIGHT_M = 0.5  # [m] above the floor


def book_rest(books: BooksThere, book: SimulatedBook) -> tuple[Rest, str | None]:
    """Return what supports a book in a physics engine, and the name of the shelf if the book is on one.

    The support is, for example, the tray or the floor. The name is None if the book is not on a shelf.
    """
    for name, shelf in books.shelves.items():
        x, y, z = (shelf.inverse_pose @ book.pose)[:3, 3]
        on_board = (
            -book.depth / 2 < x < SHELF_DEPTH_M and abs(y) < shelf.half_width and abs(z) < MAX_FOOT_GAP_M
        )
        if on_board and book.tilt() < MAX_UPRIGHT_TILT_RAD:
            return Rest.TABLE, name
    if _on_tray(books, book):
        return Rest.TRAY, None
    if book.pose[2, 3] < MAX_FALLEN_HEIGHT_M or book.rest is not Rest.HAND:
        return Rest.FLOOR, None
    return book.rest, None


def _on_tray(books: BooksThere, book: SimulatedBook) -> bool:
    robot = books.scene.robot
    if not robot.has_tray:
        return False
    tray = robot.tray_shape
    x, y, z = (inverse(books.scene.world_T_base) @ book.pose @ book.thing_T_middle)[:3, 3]
    from_middle = np.abs(np.array((x, y)) - tray.middle)
    above = z - book.height / 2 - tray.top
    return bool(
        (from_middle < np.array(tray.size[:2]) / 2 + MAX_TRAY_OFFSET_M).all() and abs(above) < MAX_FOOT_GAP_M
    )
