"""True stopping errors of the robot, in front of a shelf and in front of a slot."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.simulation.books.book import SimulatedBook
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.scene import Scene
from handcart.evaluation.judging.arrival_survey import DRIVE_PRIMITIVE
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.robotics.geometry.transform import inverse

from .book_effects import APPROACH
from .library_room import STAND_OFF


def stop_errors(scene: Scene, primitive: ActionPrimitive) -> dict[str, float]:
    """Return the true errors of an action with Success: of the base in front of a shelf, or of a held book in
    front of its slot.

    The errors are by name, in the unit at the end of the name; empty for actions that stop elsewhere.
    """
    if primitive.label() == DRIVE_PRIMITIVE:
        return _dock(scene, str(getattr(primitive, "place", "")))
    if primitive.label() == APPROACH:
        return _slot(scene, str(getattr(primitive, "shelf", "")))
    return {}


def _dock(scene: Scene, place: str) -> dict[str, float]:
    """Return the errors of distance and heading in front of a shelf."""
    shelves = scene.of(BookProps).shelves
    if place not in shelves:
        return {}
    shelf_T_base = inverse(shelves[place].pose) @ scene.world_T_base
    off = 1e3 * abs(float(shelf_T_base[0, 3]) + STAND_OFF)
    turned = abs(math.degrees(math.atan2(shelf_T_base[1, 0], shelf_T_base[0, 0])))
    along = 1e3 * abs(float(shelf_T_base[1, 3]))
    return {"dock_mm": round(off, 2), "dock_deg": round(turned, 3), "dock_along_mm": round(along, 1)}


def _slot(scene: Scene, shelf: str) -> dict[str, float]:
    """Return the distance of the held book's leading edge from the middle of the slot in front of it."""
    book, books = scene.held, scene.of(BookProps)
    if shelf not in books.shelves or not isinstance(book, SimulatedBook):
        return {}
    edge = inverse(books.shelves[shelf].pose) @ book.pose @ np.array([book.depth, 0.0, 0.0, 1.0])
    row = books.shelf_books(shelf)
    left = [
        standing_book.lateral - standing_book.book.thickness / 2
        for standing_book in row
        if standing_book.lateral > edge[1]
    ]
    right = [
        standing_book.lateral + standing_book.book.thickness / 2
        for standing_book in row
        if standing_book.lateral <= edge[1]
    ]
    if not left or not right:
        return {}
    return {"edge_mm": round(1e3 * abs(float(edge[1]) - 0.5 * (min(left) + max(right))), 3)}
