"""Calibrating a camera: focal length, centre and distortion from views of a board."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.calibration_board import BoardView
from handcart.robotics.perception.cameras.camera_model import CameraModel

FEWEST_VIEWS = 8
LEAST_TILT = 0.25
"""Minimum angle between the most different directions from which the board was seen, in [rad]."""
LEAST_COVER = 0.6
"""Minimum share of the image's 6 by 4 fields that held a corner in some view."""
_FIELDS = (6, 4)
SIGNIFICANT_SIGMAS = 4.0  # standard deviations that one more coefficient of the lens has to be from 0


_MORE_OF_THE_LENS = ((cv2.CALIB_ZERO_TANGENT_DIST, [2, 3]), (cv2.CALIB_FIX_K3, [4]))
"""Flags of OpenCV that leave coefficients out, and the indices of these, in the order of trials."""


class CameraCalibration(NamedTuple):
    """Result of calibrating a camera, with the camera model and its accuracy."""

    camera: CameraModel
    sigmas: FloatArray
    """(9,) standard deviations of fx, fy, cx, cy in [px], k1, k2, p1, p2, k3."""
    rms: float
    """Root mean square error of all corners, in [px]."""
    rms_of_views: FloatArray
    """Root mean square error (n,) of the corners in each view, in [px]."""
    camera_T_board: list[Transform]
    """Pose (4, 4) of the board in each view."""


def calibrate_camera(
    views: Sequence[BoardView],
    width: int,
    height: int,
    worst_rms: float = 0.5,
    square_pixels: bool = False,
) -> CameraCalibration:
    """Return a camera's intrinsics, and as many distortion coefficients of its lens as the views determine.

    The method is that of Zhang, "A flexible new technique for camera calibration" (2000), which needs only
    several views of a flat board. The radial coefficients k1 and k2 are always fitted. The tangential ones p1
    and p2, and then the radial k3, are fitted if they are significant and improve Bayes' information
    criterion (Schwarz, 1978).

    Args:
        views: corners of one board in at least `FEWEST_VIEWS` images.
        width: width of the images, in [px].
        height: height of the images, in [px].
        worst_rms: largest accepted root mean square error of the corners, in [px].
        square_pixels: True to fit one focal length for both axes.

    Raises:
        ValueError: there are too few views; or the views are too similar to determine all values, for example
            if the board is always seen straight on, or there are no corners in parts of the image; or the fit
            is worse than `worst_rms`.
    """
    _check_views(views, width, height)
    flags = cv2.CALIB_FIX_ASPECT_RATIO if square_pixels else 0
    flags |= sum(flag for flag, _ in _MORE_OF_THE_LENS)
    found = _fit(views, width, height, flags)
    for flag, more in _MORE_OF_THE_LENS:
        richer = _fit(views, width, height, flags & ~flag)
        if _borne(found, richer, more, sum(len(view.pixels) for view in views)):
            found, flags = richer, flags & ~flag
    _check_tilt(found.camera_T_board)
    if not found.rms <= worst_rms:
        raise ValueError(
            f"corners are {found.rms:.2f} px (rms) from where the model has them; {worst_rms:g} is allowed: "
            "is the board flat, its size right, the picture sharp?"
        )
    return found


def _borne(found: CameraCalibration, richer: CameraCalibration, more: list[int], corners: int) -> bool:
    """Return True if that many corners, of two coordinates each, determine the additional coefficients
    `more`.
    """
    numbers = 2 * corners
    gain = 2 * numbers * math.log(found.rms / max(richer.rms, 1e-12))
    value, sigma = richer.camera.distortion[more], richer.sigmas[4:][more]
    significant = bool((np.abs(value) > SIGNIFICANT_SIGMAS * sigma).any())
    return significant and gain > len(more) * math.log(numbers)


def _fit(views: Sequence[BoardView], width: int, height: int, flags: int) -> CameraCalibration:
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
    rms, K, distortion, turns, origins, sigmas, _, of_views = cv2.calibrateCameraExtended(
        [view.points.astype(np.float32) for view in views],
        [view.pixels.astype(np.float32) for view in views],
        (width, height),
        np.eye(3),
        np.zeros(5),
        flags=flags,
        criteria=criteria,
    )
    poses = [
        _pose(turn.astype(np.float64), origin.astype(np.float64))
        for turn, origin in zip(turns, origins, strict=True)
    ]
    camera = CameraModel(K.astype(np.float64), distortion.ravel().astype(np.float64), width, height)
    first = sigmas.ravel()[:9].astype(np.float64)
    return CameraCalibration(camera, first, float(rms), of_views.ravel().astype(np.float64), poses)


def _pose(turn: FloatArray, origin: FloatArray) -> Transform:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], origin.ravel()
    return pose


def _check_views(views: Sequence[BoardView], width: int, height: int) -> None:
    if len(views) < FEWEST_VIEWS:
        raise ValueError(f"there are {len(views)} views of the board; at least {FEWEST_VIEWS} are needed")
    pixels = np.vstack([view.pixels for view in views])
    fields = np.floor((pixels + 0.5) / (width, height) * _FIELDS).astype(int)
    cover = len(np.unique(fields, axis=0)) / (_FIELDS[0] * _FIELDS[1])
    if cover < LEAST_COVER:
        raise ValueError(
            f"the board was seen in {cover:.0%} of the image only; {LEAST_COVER:.0%} are needed: hold it "
            "to the image's corners too"
        )


def _check_tilt(poses: Sequence[Transform]) -> None:
    normals = np.array([pose[:3, 2] for pose in poses])
    most = float(np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0)))
    if most < LEAST_TILT:
        raise ValueError(
            f"the board was seen from directions that differ by {most:.2f} rad only; {LEAST_TILT:g} are "
            "needed: tilt it, or the camera, to all sides"
        )
