"""Utilization of an arm's joint limits while it tracks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.numerics.arrays import FloatArray

_ROUNDING = 1e-9


class LimitUse(NamedTuple):
    """Speed and torque at each set-point, as fractions of the joints' limits, with 1 at the limit."""

    speed: FloatArray
    """Joint speeds (k, n) as shares of their limits."""
    torque: FloatArray
    """Joint torques (k, n) as shares of their limits."""

    @property
    def violations(self) -> int:
        """Number of speeds and torques beyond their limits, over all set-points and joints."""
        return int((self.speed > 1.0 + _ROUNDING).sum() + (self.torque > 1.0 + _ROUNDING).sum())


class ArmLoad:
    """Computation of an arm's joint torques in motion, by recursive Newton-Euler; the base is upright.

    Attributes:
        torque: torque limits (n,) of the joints as in the URDF, in [Nm].
    """

    def __init__(self, arm: ArmModel) -> None:
        self._arm = arm
        self._model = arm.for_collision()[0]
        self._data = self._model.createData()
        self.torque: FloatArray = arm.effort_limits()

    def torques(self, q: FloatArray, speed: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return the joint torques (n,), in [Nm], for joint angles (n,) in [rad], speeds (n,) in [rad/s] and
        accelerations (n,) in [rad/s²].
        """
        arm = self._arm
        moved = arm.ordered(q), arm.ordered_rates(speed), arm.ordered_rates(acceleration)
        return arm.of_arm(pin.rnea(self._model, self._data, *moved))

    def push(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """Return the torques (n,) in [Nm] for a force (3,) of the tool on its surroundings.

        Args:
            q: (n,) joint angles in [rad].
            force: (3,) in [N], in the base's axes.
        """
        return np.asarray(self._arm.jacobian(q)[:3].T @ force)

    def use(
        self, set_points: FloatArray, period: float, torque: FloatArray, push: FloatArray | None = None
    ) -> LimitUse:
        """Return the joints' speeds and torques as shares of their limits, for a motion from rest to rest.

        Args:
            set_points: (k, n) joint angles, one row each period, in [rad].
            period: time between two set-points, in [s].
            torque: torque limits (n,), in [Nm].
            push: torques (k, n) of the tool's work, in [Nm]; their size is added to the motion's torques,
                whatever their sign. None: the tool does no work.
        """
        padded = np.vstack((set_points[:1], set_points, set_points[-1:]))
        steps = np.diff(padded, axis=0) / period
        middle = 0.5 * (steps[1:] + steps[:-1])
        acceleration = np.diff(steps, axis=0) / period
        loads = np.array([self.torques(*row) for row in zip(set_points, middle, acceleration, strict=True)])
        more = np.zeros_like(loads) if push is None else np.abs(push)
        fastest = np.maximum(np.abs(steps[1:]), np.abs(steps[:-1]))
        return LimitUse(fastest / self._arm.velocity, (np.abs(loads) + more) / torque)
