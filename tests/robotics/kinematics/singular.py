"""Distance of postures from singular ones."""

from __future__ import annotations

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray


def smallest_gain(arm: ArmModel, q: FloatArray) -> float:
    """Return the smallest singular value of the Jacobian, with 1 m equal to 1 rad; 0 in a singular posture.

    `q` is (n,) joint angles in [rad] or [m].
    """
    return float(np.linalg.svd(arm.jacobian(q), compute_uv=False)[-1])
