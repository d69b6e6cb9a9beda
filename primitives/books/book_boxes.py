"""Boxes of what arms must not touch around books."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.place import Shelf
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import HELD_NAME

from .book_grip import GRIP_HEIGHT, hand_to_spine
from .catalogue import Book

SPINE_OVERHANG_M = 0.004  # of spines before a shelf's front
SHELF_HEIGHT_M = 0.35  # above its board that a shelf may be filled, or closed
PANEL_THICKNESS_M = 0.03  # at most, of its sides
ON_TRAY = (0.005, 0.15, 0.10, 0.26)  # [m] from its rear: depth, width and height of the room for a book
SHELF_DEPTH_M = 0.25  # of its depth that counts


def shelf_boxes(base_T_shelf: Transform, shelf: Shelf) -> tuple[Box, ...]:
    """Return boxes of a shelf as obstacles for the arm, in the base frame.

    The shelf is filled with books, so that its box is solid and begins just before their spines.

    Args:
        base_T_shelf: (4, 4) measured pose of the shelf.
        shelf: dimensions of the shelf.
    """
    depth, height = SHELF_DEPTH_M + SPINE_OVERHANG_M, shelf.board_m + SHELF_HEIGHT_M
    middle = transform((depth / 2 - SPINE_OVERHANG_M, 0.0, height / 2 - shelf.board_m))
    width = max(shelf.width_m, shelf.front_m) + 2 * PANEL_THICKNESS_M
    return (Box(base_T_shelf @ middle, (depth, width, height), "the shelf"),)


def tray_box(robot: Robot) -> Box:
    """Return the region of the tray that may hold a book, in the base frame."""
    rear, *size = ON_TRAY
    tray = robot.spec.tray_shape
    middle = transform((tray.rear + rear + size[0] / 2, tray.middle[1], tray.top + size[2] / 2))
    return Box(middle, (size[0], size[1], size[2]), "book on the tray")


def held_box(robot: Robot, book: Book) -> Box:
    """Return the box of a held book in the hand frame, if the primitive PICK_UP has gripped it."""
    depth, thickness, height = (1e-3 * size for size in (book.depth_mm, book.thickness_mm, book.height_mm))
    middle = transform((hand_to_spine(robot) + depth / 2, 0.0, height / 2 - GRIP_HEIGHT))
    return Box(middle, (depth, thickness, height), HELD_NAME)
