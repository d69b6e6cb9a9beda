"""Pose of a calibration board, with its accuracy in one view."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.transform import Transform, apply
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.calibration_board import BoardView
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.planar_pose import planar_poses

_LEAST_NOISE = 0.02  # [px]: no corner is believed to be better


class PosedBoard(NamedTuple):
    """Pose of a calibration board estimated from one view, with its covariance."""

    camera_T_board: Transform
    """Pose (4, 4) of the board."""
    covariance: FloatArray
    """(6, 6) of its shift (x, y, z) in [m] and turn in [rad], in camera axes, about the board's middle."""
    rms: float
    """Root mean square error of the corners, in [px]."""


def pose_board(view: BoardView, camera: CameraModel) -> PosedBoard:
    """Return the pose camera_T_board of a calibration board that fits its corners in one image best.

    Raises:
        ValueError: the corners are not an image of a board.
    """
    rays = camera.undistort(view.pixels)
    try:
        start = planar_poses(view.points, rays)[0].camera_T_plane
    except ValueError:
        raise ValueError("the corners are not an image of a board") from None
    first_turn, first_origin = cv2.Rodrigues(start[:3, :3])[0], start[:3, 3].copy()
    turn, origin = cv2.solvePnPRefineLM(view.points, rays, np.eye(3), None, first_turn, first_origin)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], origin.ravel()
    off = camera.project(apply(pose, view.points)) - view.pixels
    rms = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
    spread = float(np.sqrt(np.sum(off**2) / (off.size - 6)))  # six numbers were fitted
    noise = max(_LEAST_NOISE, spread) / float(camera.K[0, 0])
    return PosedBoard(pose, _covariance(pose, view.points, noise), rms)


def _covariance(pose: Transform, points: FloatArray, noise: float) -> FloatArray:
    """Return the covariance (6, 6) of a pose for rays (x/z, y/z) with the standard deviation `noise`."""
    seen = apply(pose, points)
    arms = seen - pose[:3, 3]
    x, y, depth = seen[:, 0] / seen[:, 2], seen[:, 1] / seen[:, 2], seen[:, 2]
    zero, one = np.zeros_like(x), np.ones_like(x)
    by_point = (
        np.stack([np.stack([one, zero, -x], -1), np.stack([zero, one, -y], -1)], 1) / depth[:, None, None]
    )
    # A turn w moves a point by w x arm, the arm from the board's middle.
    by_turn = np.stack([np.cross(axis, arms) for axis in np.eye(3)], axis=-1)
    J = np.concatenate([by_point, by_point @ by_turn], axis=-1).reshape(-1, 6)
    return np.asarray(noise**2 * np.linalg.inv(J.T @ J))
