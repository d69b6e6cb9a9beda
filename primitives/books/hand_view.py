"""Picture of a shelf from the camera on the hand, past the held object."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from itertools import product
from typing import NamedTuple

import cv2
import numpy as np

from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.books.book_boxes import held_box
from handcart.primitives.books.book_grip import holds
from handcart.primitives.books.catalogue import Book
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

MASK_MARGIN_PX = 5  # beside a held book that don't count: its own blur, and how exactly it sits in the hand
FINGER_LINKS = ("left_finger", "right_finger")
_ALONG = np.linspace(-0.5, 0.5, 9)


class HandView(NamedTuple):
    """Picture of the hand's camera, with the pose of the shelf in the camera's frame."""

    image: ByteArray
    camera: CameraModel
    camera_T_shelf: Transform
    """Pose (4, 4) of the shelf in the camera's frame, by the measured joints."""
    mask: BoolArray
    """(height, width), True where the shelf is seen rather than hand or held book."""


def look(robot: Robot, base_T_shelf: Transform, held: Box | None) -> Generator[None, None, HandView]:
    """Wait until the hand is at rest, and take a picture of the shelf.

    Args:
        robot: robot with its camera before the shelf.
        base_T_shelf: (4, 4) measured pose of the shelf.
        held: object in the hand, posed in the hand frame.
    """
    yield from settle(robot)
    photo = robot.photo()
    camera_T_shelf = inverse(photo.base_T_camera) @ base_T_shelf
    return HandView(photo.pixels, photo.camera, camera_T_shelf, _free(robot, held))


def held_book(robot: Robot, book: Book) -> Box | None:
    """Return the book in the hand, posed in the hand frame; None if the hand doesn't hold the book."""
    gripper = robot.backend.get(Gripper)  # type: ignore[type-abstract]
    return held_box(robot, book) if gripper is not None and holds(robot, book) else None


def _free(robot: Robot, held: Box | None) -> BoolArray:
    camera = robot.camera.model
    shown = np.full((camera.height, camera.width), 255, dtype=np.uint8)
    camera_T_hand = inverse(robot.camera.hand_T_camera)
    for box in (*_fingers(robot), *([held] if held is not None else [])):
        points = apply(camera_T_hand @ box.pose, _edges(box))
        pixels = camera.project(points[points[:, 2] > 0.005])
        if len(pixels):
            cv2.fillConvexPoly(shown, cv2.convexHull(np.rint(pixels).astype(np.int32)), 0)
    return np.asarray(
        cv2.erode(shown, np.ones((2 * MASK_MARGIN_PX + 1, 2 * MASK_MARGIN_PX + 1), np.uint8)) > 0
    )


def _fingers(robot: Robot) -> Sequence[Box]:
    """Return the fingers at their current opening, in the hand frame."""
    gripper = robot.backend.get(Gripper)  # type: ignore[type-abstract]
    if gripper is None:
        return []
    width = max(0.0, gripper.width() / 2)
    joints = robot.arm.joints()
    arm = robot.arm_model.with_others(dict.fromkeys(FINGER_LINKS, width))
    hand_T_base = inverse(arm.forward(joints))
    bodies = [body for body in arm.link_shapes(joints) if body.name in FINGER_LINKS]
    return [Box(hand_T_base @ body.pose, body.size) for body in bodies if isinstance(body, Box)]


def _edges(box: Box) -> FloatArray:
    """Return points (108, 3) on a box's edges, in the box's frame in [m]: a lens bends the lines between
    corners.
    """
    ends = list(product((-0.5, 0.5), repeat=2))
    lines = [
        np.insert(np.tile(end, (len(_ALONG), 1)), axis, _ALONG, axis=1) for axis in range(3) for end in ends
    ]
    return np.asarray(np.vstack(lines) * np.array(box.size))
