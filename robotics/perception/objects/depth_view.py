"""Points of a depth picture over a level surface whose height is known."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

BORDER_PX = 4  # from the picture's edge within which a body may be cut off
PLANE_BAND_M = 0.025  # around the expected height in which points count as the surface
PLANE_MIN_POINTS = 300
PLANE_OUTLIER_M = 0.006
PLANE_ROUNDS = 3


class DepthView(NamedTuple):
    """Points of one depth picture in the base frame, with the camera's place."""

    points: FloatArray
    """(n, 3) in the base frame, in [m]."""
    at_border: BoolArray
    """(n,) True near the picture's edge."""
    eye: FloatArray
    """(3,) place of the camera in the base frame, in [m]."""
    spacing: float
    """Angle between neighbouring pixels, in [rad]."""


class OverSurface(NamedTuple):
    """Points of a depth picture in the frame of a surface, with x and y along its sides and z the height
    above it.
    """

    points: FloatArray
    """(n, 3) in [m]."""
    at_border: BoolArray
    """(n,) True near the picture's edge."""
    eye: FloatArray
    """(3,) place of the camera, in [m]."""
    spacing: float
    """Angle between neighbouring pixels, in [rad]."""


def depth_view(depth: SingleArray, camera: CameraModel, base_T_camera: Transform) -> DepthView:
    """Return the points (n, 3) of a depth picture in the base frame, in [m].

    Args:
        depth: (h, w) depths along the optical axis, in [m]; NaN without a reading.
        camera: model of the camera.
        base_T_camera: (4, 4) pose of the optical frame (z forward).
    """
    rows, columns = np.nonzero(np.isfinite(depth))
    z = depth[rows, columns].astype(np.float64)
    rays = camera.undistort(np.column_stack((columns, rows)).astype(np.float64))
    height, width = depth.shape
    inner = (rows >= BORDER_PX) & (rows < height - BORDER_PX)
    inner &= (columns >= BORDER_PX) & (columns < width - BORDER_PX)
    points = apply(base_T_camera, np.column_stack((rays * z[:, None], z)))
    return DepthView(points, ~inner, base_T_camera[:3, 3].copy(), 1.0 / float(camera.K[0, 0]))


def over_surface(view: DepthView, base_T_surface: Transform, size: tuple[float, float]) -> OverSurface | None:
    """Return the points of a depth picture in the frame of a surface, corrected by the surface's plane as
    measured.

    The scale of a camera's depths and the pose of a camera on an arm have errors. Both errors are computed
    from the measured plane, because the surface is level and its height is known. The result is None if fewer
    than `PLANE_MIN_POINTS` points are on the plane, or the camera is not above it.

    Args:
        view: points of the picture.
        base_T_surface: (4, 4) pose of the middle of the surface's top.
        size: size of the surface along its x and y, in [m].
    """
    surface_T_base = inverse(base_T_surface)
    points, eye = apply(surface_T_base, view.points), apply(surface_T_base, view.eye[None])[0]
    near = (np.abs(points[:, :2]) < np.array(size) / 2).all(axis=1) & (np.abs(points[:, 2]) < PLANE_BAND_M)
    plane = _plane(points[near])
    if plane is None or eye[2] < PLANE_BAND_M:
        return None
    offset, slopes = float(plane[0] + plane[1:] @ eye[:2]), plane[1:]
    scale = (eye[2] - offset) / eye[2]  # of the measured to the true distance, straight down
    off = (points - eye) / scale
    off[:, 2] -= off[:, :2] @ slopes
    return OverSurface(eye + off, view.at_border, eye, view.spacing)


def _plane(points: FloatArray) -> FloatArray | None:
    """Return (3,): height at the origin and slopes along x and y of the plane through most points (n, 3)."""
    kept = points
    found: FloatArray | None = None
    for _ in range(PLANE_ROUNDS):
        if len(kept) < PLANE_MIN_POINTS:
            return None
        A = np.column_stack([np.ones(len(kept)), kept[:, :2]])
        found = np.asarray(np.linalg.lstsq(A, kept[:, 2], rcond=None)[0], dtype=np.float64)
        off = points[:, 2] - found[0] - points[:, :2] @ found[1:]
        kept = points[np.abs(off) < PLANE_OUTLIER_M]
    return found
