"""Poses of planes by the image of their points, also where the camera looks straight at them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.transform import apply, difference, transform
from handcart.robotics.perception.cameras.board_pose import pose_board
from handcart.robotics.perception.cameras.calibration_board import BoardView
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.planar_pose import planar_poses
from handcart.robotics.perception.landmarks.landmark_pose import facing
from handcart.robotics.perception.landmarks.tag_reader import Tag, tag_pose

CAMERA = CameraModel(
    np.array([[800.0, 0.0, 320.0], [0.0, 800.0, 240.0], [0.0, 0.0, 1.0]]), np.zeros(5), 640, 480
)
SQUARE = 0.02 * np.array([(-1.0, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, -1.0, 0.0), (-1.0, -1.0, 0.0)])
GRID = 0.01 * np.array([(x, y, 0.0) for y in range(5) for x in range(8)])
TURNS = (0.0, math.pi / 2, math.pi, -math.pi / 2, 0.7, *np.linspace(-3.0, 3.0, 40).tolist())


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 0.3])
def test_tags_are_posed_at_any_turn_also_seen_straight(tilt: float) -> None:
    """Seen straight, a tag's image is an exact square: OpenCV's own turn of it is not a number."""
    for turn in TURNS:
        pose = facing(0.8) @ transform(rpy=(tilt, tilt, turn))
        pixels = CAMERA.project(apply(pose, SQUARE))
        found = tag_pose(Tag(1, pixels), CAMERA, 0.04)
        off, angle = difference(found, pose)
        assert off < 1e-5
        assert angle < 2e-3


def test_tags_with_corners_on_whole_pixels_are_posed() -> None:
    pixels = np.array([(310.0, 230.0), (330.0, 230.0), (330.0, 250.0), (310.0, 250.0)])
    for first in range(4):
        found = tag_pose(Tag(1, np.roll(pixels, first, axis=0)), CAMERA, 0.04)
        assert found[:3, 3] == pytest.approx((0.0, 0.0, 1.6), abs=1e-4)
        assert found[:3, 2] == pytest.approx((0.0, 0.0, -1.0), abs=1e-3)  # its front is seen


@pytest.mark.parametrize("behind", [False, True])
def test_boards_are_posed_at_any_turn_also_seen_straight(behind: bool) -> None:
    """The board's z axis points at the camera, or away from it."""
    for turn in TURNS:
        pose = facing(0.5) @ transform(rpy=(math.pi if behind else 0.0, 0.0, turn))
        found = pose_board(BoardView(GRID, CAMERA.project(apply(pose, GRID))), CAMERA)
        off, angle = difference(found.camera_T_board, pose)
        assert off < 1e-6
        assert angle < 1e-5
        assert np.isfinite(found.covariance).all()


def test_rays_of_no_plane_are_refused() -> None:
    with pytest.raises(ValueError, match="a ray is not a number"):
        planar_poses(SQUARE, np.full((4, 2), math.nan))
