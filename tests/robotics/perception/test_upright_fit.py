"""Pose of an upright box by its tag from afar: blur, and the other pose that fits too."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.transform import apply, inverse, transform
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.tag_reader import Tag, tag_poses
from handcart.robotics.perception.objects.upright_fit import TagView, fit_upright

SIDE = 0.04
CAMERA = CameraModel(np.array([[800.0, 0, 319.5], [0, 800.0, 239.5], [0, 0, 1]]), np.zeros(5), 640, 480)
SQUARE = np.array([[-1.0, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * SIDE / 2
TOP = transform((0.0, 0.0, 0.08))
base_T_box = transform((0.75, 0.1, 0.6), (0.0, 0.0, 0.4))
LOOK = np.array([[0.0, -0.6, 0.8], [-1.0, 0.0, 0.0], [0.0, -0.8, -0.6]])  # ahead and down


def view(inset: float) -> TagView:
    """The tag on the box from 1 m away, its corners moved towards its middle."""
    camera = np.eye(4)
    camera[:3, :3], camera[:3, 3] = LOOK, (-0.05, 0.1, 1.28)
    on_box = apply(TOP, SQUARE)
    corners = CAMERA.project(apply(inverse(camera) @ base_T_box, on_box))
    outwards = corners - corners.mean(axis=0)
    return TagView(
        CAMERA, camera, corners - inset * outwards / np.linalg.norm(outwards, axis=1)[:, None], on_box
    )


@pytest.mark.parametrize("inset", [0.0, 0.4])
def test_blurred_corners_of_a_far_tag_are_no_distance(inset: float) -> None:
    fit = fit_upright([view(inset)], base_T_box, 0.6, 0.003)
    assert np.linalg.norm(fit.base_T_box[:2, 3] - base_T_box[:2, 3]) < 0.0015
    assert fit.rms_px < 0.2


def test_both_poses_of_a_far_tag_fit_and_one_is_upright() -> None:
    seen = view(0.0)
    found = tag_poses(Tag(7, seen.corners), CAMERA, SIDE)
    tilts = [np.degrees(np.arccos((seen.base_T_camera @ pose.camera_T_tag)[2, 2])) for pose in found]
    assert len(found) == 2 and found[0].rms_px <= found[1].rms_px < 0.6
    assert min(tilts) < 1.0 and max(tilts) > 45.0
