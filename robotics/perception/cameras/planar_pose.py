"""Poses of points of a plane by their image, in closed form."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray


class PlanarPose(NamedTuple):
    """Pose of a plane that explains the image of its points, with the remaining error."""

    camera_T_plane: Transform
    """Pose (4, 4) of the plane."""
    rms: float
    """Root mean square of the points' residuals, as rays x/z, y/z."""


def planar_poses(points: FloatArray, rays: FloatArray) -> list[PlanarPose]:
    """Return the poses of a plane that fit an image of its points, the better one first.

    There are two, computed by the method of Collins and Bartoli, "Infinitesimal plane-based pose estimation"
    (2014). OpenCV's implementation divides by the sine of the plane's turn, which is half a turn where the
    plane's z axis points straight at the camera. The plane is therefore turned before, to where it is seen
    upright with its z axis away from the camera. Seen straight, both poses are the same, and rounding may
    leave none: then it is computed by the method of Terzakis and Lourakis, SQPnP (2020).

    Args:
        points: (n, 3) points of the plane z = 0, in [m].
        rays: (n, 2) directions x/z, y/z in which the camera sees them.

    Raises:
        ValueError: the rays are not an image of the points.
    """
    if not np.isfinite(rays).all():
        raise ValueError("a ray is not a number")
    plane_T_upright = _upright(points[:, :2], rays)
    turned, seen = np.ascontiguousarray(points @ plane_T_upright), np.ascontiguousarray(rays[:, None])
    found = list[PlanarPose]()
    for method in (cv2.SOLVEPNP_IPPE, cv2.SOLVEPNP_SQPNP):
        solved, turns, origins, errors = cv2.solvePnPGeneric(turned, seen, np.eye(3), None, flags=method)
        for turn, origin, error in zip(turns, origins, errors, strict=True) if solved else ():
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0] @ plane_T_upright.T, origin.ravel()
            if np.isfinite(pose).all():
                found.append(PlanarPose(pose, float(error[0])))
        if found:
            return found
    raise ValueError("the rays are not an image of the points")


def _upright(points: FloatArray, rays: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) of a frame of the plane that is seen upright, with z away from the camera.

    Args:
        points: (n, 2) points of the plane, in [m].
        rays: (n, 2) directions x/z, y/z in which the camera sees them.
    """
    affine = np.linalg.lstsq(points - points.mean(axis=0), rays - rays.mean(axis=0), rcond=None)[0].T
    flip = np.diag([1.0, -1.0, -1.0]) if np.linalg.det(affine) < 0.0 else np.eye(3)
    (a, b), (c, d) = affine @ flip[:2, :2]
    angle = -math.atan2(c - b, a + d)
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(flip @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]))
