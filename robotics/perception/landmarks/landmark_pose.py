"""Pose of a landmark from the positions of its corners in the picture."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.perception.landmarks.landmark import Landmark, square_corners


def planar_pose(seen: Landmark, camera_T_plane: Transform) -> Pose2:
    """Return plane_T_landmark of a landmark that lies in the plane z = 0 of a frame, face up (towards +z).

    The rays to the four corners are intersected with the plane, and the landmark is in the middle of these
    points. The landmark's size isn't used.

    Args:
        seen: the landmark as it was seen.
        camera_T_plane: (4, 4) pose of the frame.

    Raises:
        ValueError: the plane doesn't lie before the camera.
    """
    plane_T_camera = inverse(camera_T_plane)
    directions = np.column_stack([seen.rays, np.ones(4)]) @ plane_T_camera[:3, :3].T
    height = plane_T_camera[2, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = -height / directions[:, 2]
    if not (lengths > 0.0).all() or not np.isfinite(lengths).all():
        raise ValueError("the plane does not lie before the camera")
    corners = (directions * lengths[:, None] + plane_T_camera[:3, 3])[:, :2]
    centred = corners - corners.mean(axis=0)
    square = square_corners(1.0)
    # The turn that brings a square nearest to them, in closed form: the plane's Procrustes problem.
    cos = float((square[:, :2] * centred).sum())
    sin = float((square[:, 0] * centred[:, 1] - square[:, 1] * centred[:, 0]).sum())
    x, y = corners.mean(axis=0).tolist()
    return Pose2(x, y, math.atan2(sin, cos))


def facing(height: float) -> Transform:
    """Return camera_T_plane (4, 4) of a plane at right angles to the optical axis, its z towards the camera.

    The plane's x is the camera's x, its y is opposite to the camera's y. For a hand that points straight
    down, `facing(h) @ planar_pose(seen, facing(h)).lift()` is the pose C_T_P0 of Hatano et al. (2000),
    section 5.2.

    Args:
        height: distance of the plane from the camera, in [m].
    """
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = height
    return pose
