"""OpenCV's closed forms of hand-eye calibration, in this project's names."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import Transform

HAND_EYE_METHODS = {
    "Park": cv2.CALIB_HAND_EYE_PARK,
    "Horaud": cv2.CALIB_HAND_EYE_HORAUD,
    "Daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS,
    "Tsai": cv2.CALIB_HAND_EYE_TSAI,
    "Andreff": cv2.CALIB_HAND_EYE_ANDREFF,
}


def closed_form(
    base_T_hand: Sequence[Transform], camera_T_board: Sequence[Transform], method: str
) -> Transform | None:
    """Return hand_T_camera (4, 4) by one of OpenCV's closed-form methods; None if the method fails.

    In OpenCV's terms gripper2base is base_T_hand, target2cam is camera_T_board, and cam2gripper is
    hand_T_camera.

    Args:
        base_T_hand: poses (4, 4) of the hand.
        camera_T_board: poses (4, 4) of the board, one for each pose of the hand.
        method: name of one of `HAND_EYE_METHODS`.
    """
    turn, origin = cv2.calibrateHandEye(
        [hand[:3, :3] for hand in base_T_hand],
        [hand[:3, 3] for hand in base_T_hand],
        [board[:3, :3] for board in camera_T_board],
        [board[:3, 3] for board in camera_T_board],
        method=HAND_EYE_METHODS[method],
    )
    if not (np.isfinite(turn).all() and np.isfinite(origin).all() and np.linalg.det(turn) > 0.5):
        return None
    pose = np.eye(4)
    # Not all methods give a rotation exactly.
    pose[:3, :3], pose[:3, 3] = Rotation.from_matrix(turn).as_matrix(), origin.ravel()
    return pose
