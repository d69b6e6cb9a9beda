"""Force on the hand by the efforts of the arm's joints."""

from __future__ import annotations

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

_SINGULAR = 1e-3  # share of the largest singular value below which a direction isn't felt


def force_by_efforts(
    model: ArmModel, joints: FloatArray, efforts: FloatArray, known: BoolArray
) -> FloatArray:
    """Return the force of the surroundings on the hand, (3,) in [N], in the hand frame.

    The force contains the weight of a held object, but not the weight of the arm by the URDF.

    Args:
        model: model of the arm.
        joints: (n,) in [rad] or [m].
        efforts: (n,) measured efforts of the joints' motors, in [Nm] or [N].
        known: (n,) True for the joints whose efforts are known; without any, the force is zero.
    """
    if not known.any():
        return np.zeros(3)
    outside = (model.gravity_torque(joints) - efforts)[known]
    # J^T w = efforts, w force and moment at the hand; of these the force is asked for.
    wrench, *_ = np.linalg.lstsq(model.jacobian(joints).T[known], outside, rcond=_SINGULAR)
    force: FloatArray = model.forward(joints)[:3, :3].T @ wrench[:3]
    return force


def efforts_of_force(model: ArmModel, joints: FloatArray, force: FloatArray) -> FloatArray:
    """Return the efforts (n,) in [Nm] or [N] with which the joints balance the arm's weight and a hand force.

    Args:
        model: model of the arm.
        joints: (n,) in [rad] or [m].
        force: (3,) of the surroundings on the hand, in [N], in the hand frame.
    """
    world_force = model.forward(joints)[:3, :3] @ force
    efforts: FloatArray = model.gravity_torque(joints) - model.jacobian(joints)[:3].T @ world_force
    return efforts
