"""Pictures of blocks on a table and on each other, painted for these tests."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
import pytest

from robotics.geometry.pose2 import Pose2
from robotics.geometry.transform import inverse, transform
from robotics.perception.block_finder import find_block
from robotics.perception.camera_model import CameraModel

CAMERA = CameraModel(
    np.array([[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]),
    np.array([-0.28, 0.09, 0.0, 0.0, 0.0]),
    640,
    480,
)
SIZE, HEIGHT = (0.025, 0.080), 0.040
TABLE = 121.0
FINE = 6  # times finer than the image is painted


class Block(NamedTuple):
    """Its top's middle; `top` is the height of that above the plane of the block looked for, in [m]."""

    pose: Pose2
    top: float = 0.0
    size: tuple[float, float, float] = (*SIZE, HEIGHT)
    grey: float = 190.0


_FACES = (
    # shade, corners as signs of x and y and as share of the depth, in order around the face
    (1.0, ((-1, -1, 0), (-1, 1, 0), (-1, 1, 1), (-1, -1, 1))),
    (0.6, ((1, -1, 0), (1, 1, 0), (1, 1, 1), (1, -1, 1))),
    (0.8, ((-1, -1, 0), (1, -1, 0), (1, -1, 1), (-1, -1, 1))),
    (0.85, ((-1, 1, 0), (1, 1, 0), (1, 1, 1), (-1, 1, 1))),
    (1.1, ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))),
)


class Painter:
    """The lens is made once: rays of an ideal picture for all pixels."""

    size = (840, 640)

    def __init__(self) -> None:
        columns, rows = np.meshgrid(np.arange(640.0), np.arange(480.0))
        rays = CAMERA.undistort(np.column_stack([columns.ravel(), rows.ravel()]))
        self._map = (rays * 800.0 + (419.5, 319.5)).astype(np.float32).reshape(480, 640, 2)

    def __call__(self, blocks: list[Block], camera_T_plane: np.ndarray, seed: int, noise: float = 3.0):
        canvas = np.full((self.size[1] * FINE, self.size[0] * FINE), TABLE, dtype=np.uint8)
        eye = inverse(camera_T_plane)[:3, 3]
        # Far ones first: lower ones, then those farther to the side.
        for block in sorted(blocks, key=lambda b: (b.top, -math.hypot(b.pose.x - eye[0], b.pose.y - eye[1]))):
            self._block(canvas, block, camera_T_plane)
        small = cv2.resize(canvas, self.size, interpolation=cv2.INTER_AREA)
        image = cv2.remap(small, self._map, None, cv2.INTER_LINEAR).astype(np.float32)
        image = cv2.GaussianBlur(image, (0, 0), 0.7)
        rng = np.random.default_rng(seed)
        light, across = rng.uniform(-np.pi, np.pi), np.mgrid[-0.5:0.5:480j, -0.5:0.5:640j]
        image *= (1.0 + 0.25 * (math.sin(light) * across[0] + math.cos(light) * across[1])).astype(np.float32)
        image += rng.normal(0.0, noise, image.shape).astype(np.float32)
        return np.clip(np.rint(image), 0, 255).astype(np.uint8)

    def _block(self, canvas: np.ndarray, block: Block, camera_T_plane: np.ndarray) -> None:
        half = np.array([block.size[0] / 2, block.size[1] / 2, -block.size[2]])
        camera_T_top = camera_T_plane @ block.pose.lift(block.top)
        for shade, signs in _FACES:
            corners = np.array(signs) * half
            points = corners @ camera_T_top[:3, :3].T + camera_T_top[:3, 3]
            outward = (camera_T_top[:3, :3] @ corners.mean(axis=0)) if shade != 1.1 else camera_T_top[:3, 2]
            if shade != 1.1:
                middle = np.array([corners[:, 0].mean(), corners[:, 1].mean(), 0.0])
                outward = camera_T_top[:3, :3] @ middle
            if points[0] @ outward >= 0.0:
                continue
            pixels = points[:, :2] / points[:, 2:] * 800.0 + (419.5, 319.5)
            pixels = (pixels + 0.5) * FINE - 0.5
            fixed = np.rint(pixels * 16).astype(np.int32)
            cv2.fillPoly(canvas, [fixed], min(255, round(block.grey * shade)), cv2.LINE_8, 4)


@pytest.fixture(scope="module")
def paint() -> Painter:
    return Painter()


def looking(x: float, y: float, height: float, turn: float = 0.0, tilt: tuple[float, float] = (0.0, 0.0)):
    """camera_T_plane of a camera at (x, y, height) of the plane that looks down."""
    plane_T_camera = transform((x, y, height), (math.pi, 0.0, turn)) @ transform(rpy=(*tilt, 0.0))
    return inverse(plane_T_camera)
