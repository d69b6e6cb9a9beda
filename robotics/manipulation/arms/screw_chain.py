"""A serial arm as screws: the part of an `ArmModel` that compiled loops need."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import Fields


class ScrewChain(NamedTuple):
    """Kinematics of an arm with revolute joints, as a product of exponentials.

    It consists of the joint axes and the tip's pose with all angles at zero, in the frame of the arm's base:
    Lynch and Park, Modern Robotics (2017), chapter 4.
    """

    axes: FloatArray
    """(n, 3): unit vectors along the axes."""
    points: FloatArray
    """(n, 3): a point on each axis, in [m]."""
    base_T_tip: FloatArray
    """(4, 4): pose of the tip with all angles at zero."""
    lower: FloatArray
    """(n,): lower joint limits, in [rad]."""
    upper: FloatArray
    """(n,): upper joint limits, in [rad]."""

    @classmethod
    def of_arm(cls, arm: ArmModel) -> ScrewChain:
        """Return the joint axes and zero pose of an arm, computed from its Jacobian and the tip's pose with
        all joints at zero.

        Raises:
            ValueError: a joint of the arm slides.
        """
        zero = np.zeros(arm.dof)
        jacobian, base_T_tip = arm.jacobian(zero), arm.forward(zero)
        axes = jacobian[3:].T
        slides = np.linalg.norm(axes, axis=1) < 0.5
        if slides.any():
            name = arm.joint_names[int(np.argmax(slides))]
            raise ValueError(f"joint {name!r} slides; allowed: arms whose joints all turn")
        points = base_T_tip[:3, 3] + np.cross(axes, jacobian[:3].T)
        lower = np.where(arm.endless, -np.inf, arm.lower)
        upper = np.where(arm.endless, np.inf, arm.upper)
        return cls(np.ascontiguousarray(axes), points, base_T_tip, lower, upper)

    @property
    def dof(self) -> int:
        """Number n of the arm's joints."""
        return len(self.axes)

    @property
    def reach(self) -> float:
        """Upper bound of the distance of the tip from the point `points[0]` on the first joint axis, in
        [m].
        """
        knots = np.vstack((self.points, self.base_T_tip[:3, 3]))
        return float(np.linalg.norm(np.diff(knots, axis=0), axis=1).sum())


CHAIN_TYPES = Fields(ScrewChain, "(f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], f8[::1])")
"""Numba's type of a chain."""


class ChainPosture(NamedTuple):
    """Joint angles of an arm (`ScrewChain`), with arrays into which compiled functions write the tip's pose
    and Jacobian.
    """

    q: FloatArray
    """Joint angles (n,), in [rad]."""
    pose: FloatArray
    """base_T_tip (4, 4) at the angles; its last row stays as it is."""
    jacobian: FloatArray
    """Jacobian (6, n) at the angles, in the axes of the base: [m/rad] above, [rad/rad] below."""

    @classmethod
    def at(cls, q: FloatArray) -> ChainPosture:
        """Return a posture at angles `q` (n,), in [rad], whose pose and Jacobian are not computed yet; `q` is
        not copied.
        """
        return cls(q, np.eye(4), np.empty((6, len(q))))


POSTURE_TYPES = Fields(ChainPosture, "(f8[::1], f8[:,::1], f8[:,::1])")
"""Numba's type of a posture."""
