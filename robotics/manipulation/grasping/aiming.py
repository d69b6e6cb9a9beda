"""Joints that turn a camera on a head or mast towards a point."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

MAX_ITERATIONS = 30
JOINT_DIFFERENCE = 1e-5  # of a joint, for derivatives, in [rad] or [m]
LONGEST_STEP = 0.5  # in [rad] or [m]
DAMPING_FACTOR = 1e-6
AIM_TOLERANCE_RAD = 1e-4
MIN_DEPTH_M = 1e-3  # [m], least depth of the point before the camera


def aim(
    arm: ArmModel,
    frame: str,
    frame_T_camera: Transform,
    point: FloatArray,
    moving: BoolArray,
    start: FloatArray,
) -> tuple[FloatArray, float]:
    """Return joints that turn a camera towards a point, as far as the limits of the joints allow.

    Computed by damped least squares of the two angles between the optical axis and the direction to the
    point.

    Args:
        arm: kinematics whose joints move the camera.
        frame: link that carries the camera.
        frame_T_camera: (4, 4) pose of the optical frame (z forward) in that link.
        point: (3,) in the base frame of `arm`, in [m].
        moving: (n,) True for joints that may move.
        start: (n,) joints at the start, in [rad] or [m].

    Returns:
        Joints (n,) in [rad] or [m], and the remaining angle between the optical axis and the direction to the
        point, in [rad].
    """
    joints = np.array(start, dtype=np.float64)
    chosen = np.flatnonzero(moving)
    off = _angles(arm, frame, frame_T_camera, point, joints)
    for _ in range(MAX_ITERATIONS):
        if not len(chosen) or np.linalg.norm(off) < AIM_TOLERANCE_RAD:
            break
        slopes = np.empty((2, len(chosen)))
        for column, number in enumerate(chosen):
            moved = joints.copy()
            moved[number] += JOINT_DIFFERENCE
            slopes[:, column] = (_angles(arm, frame, frame_T_camera, point, moved) - off) / JOINT_DIFFERENCE
        step = -np.linalg.solve(slopes.T @ slopes + DAMPING_FACTOR * np.eye(len(chosen)), slopes.T @ off)
        longest = float(np.abs(step).max())
        following = joints.copy()
        following[chosen] += step * min(1.0, LONGEST_STEP / max(longest, 1e-12))
        following = arm.clipped(following)
        if np.abs(following - joints).max() < AIM_TOLERANCE_RAD / 10:
            break
        joints = following
        off = _angles(arm, frame, frame_T_camera, point, joints)
    return joints, float(np.linalg.norm(off))


def _angles(
    arm: ArmModel, frame: str, frame_T_camera: Transform, point: FloatArray, joints: FloatArray
) -> FloatArray:
    """Return the angles (2,) between the optical axis and a point, about the picture's y and x, in [rad]."""
    camera_T_base = inverse(arm.forward(joints, frame) @ frame_T_camera)
    x, y, z = camera_T_base[:3, :3] @ point + camera_T_base[:3, 3]
    return np.array([np.arctan2(x, z), np.arctan2(y, np.hypot(x, max(z, MIN_DEPTH_M)) if z > 0 else -z)])
