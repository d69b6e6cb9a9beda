"""A hand that is commanded into a surface slides along it, against friction."""

from __future__ import annotations

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

HAND_FRICTION = 0.4
"""Coulomb's coefficient between the hand, or the held object, and a touched body."""
_ROUNDS = 3  # of Newton's method
_DAMPING = 1e-6


def slide(
    arm: ArmModel, stands: FloatArray, target: FloatArray, point: FloatArray, normal: FloatArray
) -> FloatArray | None:
    """Return the joints of an arm whose hand slides on a surface towards `target`.

    The arm is modelled as a spring of equal stiffness in all directions. The commanded position of the hand
    is some depth behind the surface, and some distance away along the surface. The hand sticks as long as
    this distance is less than `HAND_FRICTION` times the depth; otherwise it slides until the distance is that
    large. The hand turns as commanded.

    Args:
        arm: kinematics of the arm.
        stands: (n,) joints with which the hand touches the surface, in [rad] or [m].
        target: (n,) commanded joints, in [rad] or [m].
        point: (3,) point at which the hand touches the surface, in the base frame, in [m].
        normal: (3,) unit vector away from the surface, in the base frame.

    Returns:
        (n,) joints within the limits, in [rad] or [m]; None if the hand sticks, or is commanded away from the
        surface.
    """
    tip_point = np.linalg.inv(arm.forward(stands)) @ np.append(point, 1.0)
    way = (arm.forward(target) @ tip_point)[:3] - point
    depth = -float(normal @ way)
    along = way + depth * normal
    far = float(np.linalg.norm(along))
    if depth <= 0.0 or far <= HAND_FRICTION * depth:
        return None
    goal = point + (1.0 - HAND_FRICTION * depth / far) * along
    joints = target.copy()
    for _ in range(_ROUNDS):
        off = goal - (arm.forward(joints) @ tip_point)[:3]
        joints = arm.clipped(joints + _moved_by(arm, joints, off))
    return joints


def push_out(arm: ArmModel, joints: FloatArray, way: FloatArray) -> FloatArray:
    """Return the joints (n,) that displace the hand by `way` without turning it, within the joints' limits.

    Args:
        arm: kinematics of the arm.
        joints: (n,) joints before the displacement, in [rad] or [m].
        way: (3,) displacement of the hand in the base frame, in [m].
    """
    return arm.clipped(joints + _moved_by(arm, joints, way))


def _moved_by(arm: ArmModel, joints: FloatArray, way: FloatArray) -> FloatArray:
    """Return joint steps (n,), in [rad] or [m], that move the hand but don't turn it, by damped least
    squares.

    Args:
        arm: kinematics of the arm.
        joints: (n,) current joints, in [rad] or [m].
        way: (3,) displacement of the hand in the base frame, in [m].
    """
    J = arm.jacobian(joints)
    twist = np.concatenate((way, np.zeros(3)))
    return np.asarray(J.T @ np.linalg.solve(J @ J.T + _DAMPING * np.eye(6), twist))
