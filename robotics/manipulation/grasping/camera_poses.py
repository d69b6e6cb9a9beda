"""Poses of a camera that looks at a point."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

ROLLS_RAD = tuple(math.radians(value) for value in (0.0, 180.0, 90.0, -90.0, 45.0, -45.0, 135.0, -135.0))


def from_direction(tilt: float, azimuth: float) -> FloatArray:
    """Return the unit vector (3,) at an angle `tilt` from the vertical and an azimuth, both in [rad].

    The vector is in any frame with z up; the azimuth is from x towards y, about z.
    """
    return np.array([math.sin(tilt) * math.cos(azimuth), math.sin(tilt) * math.sin(azimuth), math.cos(tilt)])


def camera_poses(
    point: FloatArray, towards: FloatArray, distance: float, rolls: Sequence[float] = ROLLS_RAD
) -> Iterator[Transform]:
    """Yield poses (4, 4) of a camera's optical frame (z forward, x right, y down) whose z axis meets a point.

    Args:
        point: (3,) in any frame with z up, in [m]; the poses are in that frame.
        towards: (3,) unit vector from the point to the camera, in the same frame.
        distance: distance from the camera to the point, in [m].
        rolls: turns about the optical axis, in [rad]; at 0 the picture's rows are level.
    """
    ahead = -towards
    level = np.cross(ahead, [0.0, 0.0, 1.0])
    right = np.array([0.0, -1.0, 0.0]) if np.linalg.norm(level) < 1e-6 else level / np.linalg.norm(level)
    down = np.cross(ahead, right)
    for roll in rolls:
        pose = np.eye(4)
        pose[:3, 0] = right * math.cos(roll) + down * math.sin(roll)
        pose[:3, 1] = np.cross(ahead, pose[:3, 0])
        pose[:3, 2], pose[:3, 3] = ahead, point + distance * towards
        yield pose


def points_in_view(
    camera: CameraModel, base_T_camera: Transform, points: FloatArray, margin_px: float
) -> BoolArray:
    """Return a mask (n,), True for points that are in the picture; occlusion is ignored.

    Args:
        camera: model of the camera.
        base_T_camera: (4, 4) pose of the optical frame.
        points: (n, 3) in the base frame, in [m].
        margin_px: least distance from the picture's edge, in [px].
    """
    pixels = camera.project(apply(inverse(base_T_camera), points))
    inside = (pixels >= margin_px) & (pixels <= np.array([camera.width, camera.height]) - 1 - margin_px)
    return np.asarray(inside.all(axis=1))
