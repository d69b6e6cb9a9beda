"""Pose of an upright box from the corners of its tags in several pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, apply, inverse, transform
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

CORNER_SIGMA_PX = 0.3
MAX_STEPS = 12
INSET_SIGMA_PX = 0.5  # by which blur moves a corner towards the middle of its tag
DERIVATIVE_STEPS = np.array([1e-5, 1e-5, 1e-5, 1e-5, 1e-4])  # [m], [m], [m], [rad], [px]: of the derivatives
SUFFICIENT_STEP = 1e-7


class TagView(NamedTuple):
    """Tag on a box as seen in one picture, with the positions of its corners on the box."""

    camera: CameraModel
    base_T_camera: Transform
    """Pose (4, 4) of the camera."""
    corners: FloatArray
    """Corners (4, 2) of the tag in the picture, in any order, column and row in [px]."""
    on_box: FloatArray
    """(4, 3) the same corners in the same order in the frame of the box, in [m]."""


class UprightFit(NamedTuple):
    """Pose of an upright box, fitted to the corners of its tags in pictures, with its accuracy."""

    base_T_box: Transform
    """Pose (4, 4) of the box."""
    covariance: FloatArray
    """(4, 4) of x, y, z in the base frame in [m] and the heading in [rad]."""
    rms_px: float
    """Root mean square of the corners' residuals, in [px]; large if the box is not upright."""


def fit_upright(views: Sequence[TagView], start: Transform, height: float, height_sigma: float) -> UprightFit:
    """Fit x, y, z and heading of an upright box to the corners of its tags in all pictures (Gauss and
    Newton).

    Blur moves the corners of a small tag inwards in the picture, which would look like a larger distance. So
    this shift is fitted too.

    Args:
        views: at least one view of a tag.
        start: (4, 4) first guess of base_T_box; its tilt is ignored.
        height: expected height (z) of the box's origin, in its foot, in the base frame, in [m].
        height_sigma: standard deviation of the expected height, in [m].
    """
    state = np.array([*start[:3, 3], np.arctan2(start[1, 0], start[0, 0]), 0.0])
    J = np.zeros((1, 5))
    residuals = np.zeros(1)
    for _ in range(MAX_STEPS):
        residuals = _residuals(views, state, height, height_sigma)
        columns = [
            (_residuals(views, state + step, height, height_sigma) - residuals) / step[number]
            for number, step in enumerate(np.diag(DERIVATIVE_STEPS))
        ]
        J = np.column_stack(columns)
        change = np.linalg.lstsq(J, -residuals, rcond=None)[0]
        state = state + change
        if float(np.abs(change).max()) < SUFFICIENT_STEP:
            break
    covariance = np.asarray(np.linalg.pinv(J.T @ J)[:4, :4])
    rms = CORNER_SIGMA_PX * float(np.sqrt(np.mean(residuals[:-2] ** 2)))
    return UprightFit(_pose(state), covariance, rms)


def _pose(state: FloatArray) -> Transform:
    return transform(state[:3].tolist(), (0.0, 0.0, float(state[3])))


def _residuals(views: Sequence[TagView], state: FloatArray, height: float, height_sigma: float) -> FloatArray:
    """Residuals (8 n + 2,) in standard deviations: the corners', that of the height, that of the inset."""
    base_T_box, inset = _pose(state), float(state[4])
    found = [(_corners(view, base_T_box, inset) - view.corners) / CORNER_SIGMA_PX for view in views]
    off = np.nan_to_num(np.concatenate([item.ravel() for item in found]), nan=1e3)
    return np.append(off, [(state[2] - height) / height_sigma, inset / INSET_SIGMA_PX])


def _corners(view: TagView, base_T_box: Transform, inset: float) -> FloatArray:
    """Return where a tag's corners (4, 2) are expected in a picture, moved towards its middle, in [px]."""
    seen = view.camera.project(apply(inverse(view.base_T_camera) @ base_T_box, view.on_box))
    outwards = seen - seen.mean(axis=0)
    return np.asarray(seen - inset * outwards / np.linalg.norm(outwards, axis=1, keepdims=True))
