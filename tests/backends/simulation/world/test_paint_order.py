from __future__ import annotations

import cv2
import numpy as np
import pytest

from handcart.backends.simulation.depth.box_depth import BoxDepth
from handcart.backends.simulation.world.canvas import Canvas
from handcart.backends.simulation.world.paint_order import painting_order
from handcart.backends.simulation.world.painting import SIDE_CORNERS
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

CAMERA = CameraModel(
    np.array([[150.0, 0.0, 79.5], [0.0, 150.0, 59.5], [0.0, 0.0, 1.0]]), np.zeros(5), 160, 120
)
OPTICAL = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])

MAX_THIN_LINE_PX = 60
"""Pixels of bodies thinner than a pixel, which are painted and which rays miss."""


def furnished(seed: int) -> list[Box]:
    """Boxes, cupboards and boards with something on and under them, one in each square of a grid."""
    draws, boxes = np.random.default_rng(seed), list[Box]()
    for x, y in [(x, y) for x in (1.5, 2.5, 3.5) for y in (-1.0, 0.0, 1.0)]:
        heading, height = draws.uniform(-3, 3), draws.uniform(0.2, 2.4)
        length, width = draws.uniform(0.05, 0.65, 2)
        pose = transform((x, y, 0.0), (0.0, 0.0, heading))
        boxes.append(Box(pose @ transform((0, 0, height / 2)), (length, width, height)))
        board = pose @ transform((0, 0, height + 0.3))
        boxes.append(Box(board, (length, width, 0.02)))
        boxes.append(Box(pose @ transform((0, 0, height + 0.1)), (length / 3, width / 3, 0.2)))
        boxes.append(Box(board @ transform((0, 0, 0.06)), (length / 2, width / 3, 0.1)))
    return [boxes[number] for number in draws.permutation(len(boxes))]


def painted(boxes: list[Box], world_T_camera: Transform) -> ByteArray:
    canvas = Canvas(CAMERA.K, (CAMERA.width, CAMERA.height), world_T_camera, 255)
    for number in painting_order(canvas, boxes):
        box = boxes[number]
        for corners in (SIDE_CORNERS * box.size) @ box.pose[:3, :3].T + box.pose[:3, 3]:
            canvas.polygon(corners, number)
    return canvas.picture


@pytest.mark.parametrize("seed", range(6))
def test_painted_bodies_are_those_that_rays_from_the_camera_meet(seed: int) -> None:
    boxes, draws = furnished(seed), np.random.default_rng(100 + seed)
    for _ in range(5):
        place = (draws.uniform(-0.5, 0.8), draws.uniform(-1.5, 1.5), draws.uniform(0.3, 2.8))
        camera = transform(place, (0.0, draws.uniform(-0.2, 0.6), draws.uniform(-0.5, 0.5))) @ OPTICAL
        _, shown = BoxDepth(CAMERA).cast(camera, boxes)
        met = np.where((shown >= 0) & (shown < len(boxes)), shown, 255).astype(np.uint8)
        around = np.ones((5, 5))
        inside = cv2.erode(met, around) == cv2.dilate(met, around)  # away from blended edges
        assert (painted(boxes, camera) != met)[inside].sum() <= MAX_THIN_LINE_PX
        assert (met != 255).mean() > 0.01


def test_without_bodies_nothing_is_ordered() -> None:
    assert painting_order(Canvas(CAMERA.K, (160, 120), np.eye(4), 0), []) == []
