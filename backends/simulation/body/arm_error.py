"""Where the hand truly comes to when an arm is sent to a posture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.simulated_errors import Errors
from handcart.backends.simulation.keyed_noise import keyed
from handcart.robotics.kinematics.arm_model import ArmModel

_SQUARED_DAMPING = 1e-4

Vector = NDArray[np.float64]


class ArmError:
    """The joints' offset from what their encoders read: gears and links give, which no encoder sees.

    Drawn anew whenever the arm sets out from rest: Gaussian in the joints, Gaussian and uniform in the
    hand's position. Systematic, drawn once for a seed: a field over the positions of the hand, smooth, along
    each axis a sine.
    """

    def __init__(self, errors: Errors, arm: ArmModel, seed: int) -> None:
        self._errors, self._arm, self._seed = errors, arm, seed
        rng = keyed(seed, "arm's systematic error")
        ways = rng.standard_normal((3, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        self._waves = 2 * math.pi / errors.hand_systematic_wave_m * ways
        self._phases = rng.uniform(-math.pi, math.pi, 3)
        self._drawn = (-1, np.zeros(0), np.zeros(3))
        self._of_hand = max(errors.hand_systematic_mm, errors.hand_repeat_mm, errors.hand_uniform_mm) > 0.0

    def offset(self, joints: Vector, motion: int) -> Vector:
        """(n,) in [rad] at the commanded `joints` (n,), in the arm's motion of that number."""
        _, offset, wrong = self._draw(motion, len(joints))
        if not self._of_hand:
            return offset
        hand = self._arm.forward(joints)[:3, 3]
        systematic = self._errors.hand_systematic_mm / math.sqrt(3.0)
        off = wrong + systematic * np.sin(self._waves @ hand + self._phases)
        J = self._arm.jacobian(joints)
        twist = np.concatenate([off / 1e3, np.zeros(3)])
        damped = J @ J.T + _SQUARED_DAMPING * np.eye(6) * 1e-4
        return np.asarray(offset + J.T @ np.linalg.solve(damped, twist))

    def _draw(self, motion: int, dof: int) -> tuple[int, Vector, Vector]:
        """What belongs to one motion: of the joints in [rad], of the hand in [mm]."""
        if self._drawn[0] != motion:
            errors, rng = self._errors, keyed(self._seed, "joint repeatability", motion)
            offset = errors.joint_repeatability_mrad / 1e3 * rng.standard_normal(dof)
            wrong = errors.hand_repeat_mm * rng.standard_normal(3)
            wrong += errors.hand_uniform_mm * rng.uniform(-1.0, 1.0, 3)
            self._drawn = (motion, offset, wrong)
        return self._drawn
