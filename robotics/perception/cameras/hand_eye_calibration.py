"""Calibrating where the camera sits on the hand, from views of a board that lies still."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.board_pose import PosedBoard, pose_board
from handcart.robotics.perception.cameras.calibration_board import BoardView
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.hand_eye_closed_form import HAND_EYE_METHODS, closed_form

FEWEST_VIEWS = 8
LEAST_TURN = 0.1
"""Minimum turn (rms) of the hand around a second axis, in [rad]."""
ARM_LEVER = 0.5
"""Length in [m] that relates the arm's errors; a position error of 1 mm goes with 1 mm of turn over it."""
_MOST_ROUNDS, _SETTLED = 12, 0.02
_LEAST_ARM_ERROR = 1e-6  # [m]


class HandEyeView(NamedTuple):
    """Calibration board as seen by the camera on the hand, from one posture of the arm."""

    base_T_hand: Transform
    """Pose (4, 4) of the hand by the arm's joints."""
    board: BoardView


class HandEyeCalibration(NamedTuple):
    """Result of a hand-eye calibration, the pose of the camera on the hand with its accuracy and
    residuals.
    """

    hand_T_camera: Transform
    """Pose (4, 4) of the camera."""
    base_T_board: Transform
    """Pose (4, 4) of the board."""
    sigmas: FloatArray
    """(6,) standard deviations of hand_T_camera: position in [m], turn in [rad], in the camera frame."""
    rms: float
    """Root mean square distance of all corners from their predicted positions, in [px]."""
    offsets: FloatArray
    """(n,) distance between the board's middle by each view alone and by `base_T_board`, in [m]."""
    arm_error: float
    """Error of the hand's position estimated from the views, rms of each axis, in [m]."""
    method: str
    """Name of the closed form from which the refinement started."""


def calibrate_hand_eye(
    views: Sequence[HandEyeView], camera: CameraModel, worst_offset: float = 0.005
) -> HandEyeCalibration:
    """Return hand_T_camera from views by a calibrated camera, with the base at rest.

    OpenCV's closed forms give start values. Then hand_T_camera and base_T_board are adjusted until the
    board's poses fit best. Each pose is weighted by the accuracy of its corners and by the arm's own error,
    which is estimated too. Minimizing the distances of the corners in the images would assume an exact arm,
    and give worse results than the closed forms.

    Args:
        views: at least `FEWEST_VIEWS` views of a board that lies still.
        camera: calibrated model of the camera.
        worst_offset: largest accepted distance of a view's board centre from the common one, in [m].

    Raises:
        ValueError: there are too few views; or the hand turned too little, or around one axis only, so that
            the camera's offset along that axis is unknown; or the board's centre in a view is more than
            `worst_offset` from the common one.
    """
    _check(views)
    boards = [pose_board(view.board, camera) for view in views]
    method, poses = _best_start(views, boards)
    arm_error = _arm_error(views, boards, poses)
    for _ in range(_MOST_ROUNDS):
        weights = [
            _weight(view, board, poses[0], arm_error) for view, board in zip(views, boards, strict=True)
        ]
        poses, jacobian, unexplained = _fit(views, boards, weights, poses)
        if abs(unexplained - 1.0) < _SETTLED or (unexplained < 1.0 and arm_error <= _LEAST_ARM_ERROR):
            break
        arm_error = max(_LEAST_ARM_ERROR, arm_error * float(np.sqrt(unexplained)))
    offsets = np.linalg.norm(_off(views, boards, poses)[:, :3], axis=1)
    if not offsets.max() <= worst_offset:
        raise ValueError(
            f"view {int(offsets.argmax())} puts the board {1e3 * offsets.max():.1f} mm from where all do, "
            f"{1e3 * worst_offset:g} mm are allowed: did base or board move, is the arm calibrated?"
        )
    sigmas = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)) * unexplained)[:6]
    return HandEyeCalibration(
        *poses, np.asarray(sigmas), _rms(views, camera, poses), offsets, arm_error, method
    )


def _check(views: Sequence[HandEyeView]) -> None:
    if len(views) < FEWEST_VIEWS:
        raise ValueError(f"there are {len(views)} views of the board; at least {FEWEST_VIEWS} are needed")
    turns = np.array([view.base_T_hand[:3, :3] for view in views])
    mean = Rotation.from_matrix(turns).mean().as_matrix()
    axes = Rotation.from_matrix(mean.T @ turns).as_rotvec()
    second = float(np.linalg.svd(axes, compute_uv=False)[1]) / np.sqrt(len(views))
    if second < LEAST_TURN:
        raise ValueError(
            f"around a second axis the hand turned by {second:.2f} rad (rms); {LEAST_TURN:g} are needed: "
            "look at the board from all sides"
        )


def _best_start(
    views: Sequence[HandEyeView], boards: Sequence[PosedBoard]
) -> tuple[str, tuple[Transform, Transform]]:
    """Return the closed form by which all views put the board most alike, and poses of camera and board."""
    starts = []
    for method in HAND_EYE_METHODS:
        hand_T_camera = closed_form(
            [view.base_T_hand for view in views], [board.camera_T_board for board in boards], method
        )
        if hand_T_camera is None:
            continue
        placed = [
            view.base_T_hand @ hand_T_camera @ board.camera_T_board
            for view, board in zip(views, boards, strict=True)
        ]
        base_T_board = np.eye(4)
        base_T_board[:3, :3] = Rotation.from_matrix([item[:3, :3] for item in placed]).mean().as_matrix()
        base_T_board[:3, 3] = np.median([item[:3, 3] for item in placed], axis=0)
        off = _off(views, boards, (hand_T_camera, base_T_board))
        starts.append((float(np.linalg.norm(off[:, :3])), method, (hand_T_camera, base_T_board)))
    if not starts:
        raise ValueError("no method finds a place for the camera: are poses and pictures in the same order?")
    _, method, start = min(starts, key=lambda item: item[0])
    return method, start


def _off(
    views: Sequence[HandEyeView], boards: Sequence[PosedBoard], poses: tuple[Transform, Transform]
) -> FloatArray:
    """Return (n, 6) expected camera_T_board less the seen one: shift in [m] and turn in [rad], in camera
    axes.
    """
    hand_T_camera, base_T_board = poses
    expected = np.array([inverse(view.base_T_hand @ hand_T_camera) @ base_T_board for view in views])
    seen = np.array([board.camera_T_board for board in boards])
    turns = Rotation.from_matrix(expected[:, :3, :3] @ seen[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
    return np.hstack([expected[:, :3, 3] - seen[:, :3, 3], turns])


def _arm_error(
    views: Sequence[HandEyeView], boards: Sequence[PosedBoard], poses: tuple[Transform, Transform]
) -> float:
    """Return a first guess of the arm's position error, in [m]."""
    return max(_LEAST_ARM_ERROR, float(np.sqrt(np.mean(_off(views, boards, poses)[:, :3] ** 2))))


def _weight(view: HandEyeView, board: PosedBoard, hand_T_camera: Transform, arm_error: float) -> FloatArray:
    """Return the matrix (6, 6) that makes a view's residuals uncorrelated and of unit variance."""
    camera_T_hand = inverse(hand_T_camera)
    lever = board.camera_T_board[:3, 3] - camera_T_hand[:3, 3]
    x, y, z = lever.tolist()
    by_hand = np.eye(6)
    by_hand[3:, 3:] *= -1.0
    by_hand[:3, 3:] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    of_hand = np.repeat([arm_error, arm_error / ARM_LEVER], 3) ** 2
    covariance = board.covariance + (by_hand * of_hand) @ by_hand.T
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def _fit(
    views: Sequence[HandEyeView],
    boards: Sequence[PosedBoard],
    weights: Sequence[FloatArray],
    start: tuple[Transform, Transform],
) -> tuple[tuple[Transform, Transform], FloatArray, float]:
    """Return both poses, the jacobian (6 n, 12), and the variance that is left, 1 if the weights are
    right.
    """
    weight = np.array(weights)

    def residuals(step: FloatArray) -> FloatArray:
        off = _off(views, boards, _moved(start, step))
        return np.ravel(weight @ off[..., None])

    found = least_squares(residuals, np.zeros(12), x_scale="jac", xtol=1e-10)
    unexplained = float(found.fun @ found.fun) / (len(found.fun) - 12)
    return _moved(start, found.x), found.jac, unexplained


def _moved(poses: tuple[Transform, Transform], step: FloatArray) -> tuple[Transform, Transform]:
    """Return both poses moved, in their own frames, by a shift in [m] and a turn in [rad] each (12,)."""
    moved = []
    for pose, part in zip(poses, (step[:6], step[6:]), strict=True):
        change = np.eye(4)
        change[:3, :3], change[:3, 3] = Rotation.from_rotvec(part[3:]).as_matrix(), part[:3]
        moved.append(pose @ change)
    return moved[0], moved[1]


def _rms(views: Sequence[HandEyeView], camera: CameraModel, poses: tuple[Transform, Transform]) -> float:
    """Return the root mean square error of all corners, in [px]."""
    hand_T_camera, base_T_board = poses
    off = [
        camera.project(apply(inverse(view.base_T_hand @ hand_T_camera) @ base_T_board, view.board.points))
        - view.board.pixels
        for view in views
    ]
    return float(np.sqrt(np.mean(np.sum(np.vstack(off) ** 2, axis=1))))
