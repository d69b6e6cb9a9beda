"""Odometry of a base that drives in any direction, with an honest covariance."""

from __future__ import annotations

import math

import numpy as np
from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray

from .odometry import Odometry, OdometryErrors, SidewaysErrors


class HolonomicOdometry(Odometry):
    """Odometry of a base that can drive sideways, by the wheels' travel on both sides and sideways.

    Wheels of unequal size or load turn a base that drives sideways, and move it ahead. On mecanum wheels
    these errors are larger than those of driving ahead (Adascalitei and Doroftei 2011). They are constant, so
    they are estimated together with the states of `Odometry`: relative error of the distance sideways, motion
    ahead for each metre sideways, and turn for each metre sideways.
    """

    @staticmethod
    @override
    def _constant_sigmas(errors: OdometryErrors) -> tuple[float, ...]:
        sideways = errors.sideways or SidewaysErrors()
        return (*Odometry._constant_sigmas(errors), sideways.scale, sideways.scale, sideways.turn)

    @override
    def predict(self, left: float, right: float, sideways: float = 0.0) -> None:
        if left == 0.0 and right == 0.0 and sideways == 0.0:
            self.pose = self.pose._replace(theta=wrap(self.pose.theta))
            return
        left_scale, right_scale, tread_scale, scale, ahead, turned = self._scales.tolist()
        tread = self.tread * (1.0 + tread_scale)
        moved_left, moved_right = left * (1.0 + left_scale), right * (1.0 + right_scale)
        rolled = (moved_right - moved_left) / tread
        turn = rolled + sideways * turned
        forward = 0.5 * (moved_left + moved_right) + sideways * ahead
        moved = _twist(forward, sideways * (1.0 + scale), turn)
        by_body = _body_jacobian(moved, self.pose.theta, turn)
        by_state = np.array(
            [
                [0.5 * left, 0.5 * right, 0.0, 0.0, sideways, 0.0],
                [0.0, 0.0, 0.0, sideways, 0.0, 0.0],
                [-left / tread, right / tread, -rolled, 0.0, 0.0, sideways],
            ]
        )
        step = np.eye(9)
        across = np.array([-math.sin(self.pose.theta), math.cos(self.pose.theta)])
        along = np.array([across[1], -across[0]])
        step[:2, 2] = across * moved.x - along * moved.y
        step[:3, 3:] = by_body @ by_state
        before = float(self._state[2, 2])
        self._state = step @ self._state @ step.T
        self._origin = self._origin.stepped(step)
        slips = by_body @ self._slip_covariance(left, right, sideways, tread) @ by_body.T
        self._state[:3, :3] += slips
        after = self.pose.compose(moved)
        self._bend(after.x - self.pose.x, after.y - self.pose.y, before, float(slips[2, 2]))
        self.pose = after

    @override
    def sideways_turn_variance(self, sideways: float) -> float:
        slip = (self._errors.sideways or SidewaysErrors()).slip
        return slip**2 * self._errors.slip_length * abs(sideways) * (2.0 / self.tread) ** 2

    @override
    def turn_variance(self, left: float, right: float, sideways: float = 0.0) -> float:
        by_scale = np.array([-left, right, -(right - left), 0.0, 0.0, sideways * self.tread]) / self.tread
        return float(by_scale @ self._state[3:, 3:] @ by_scale)

    def _slip_covariance(self, left: float, right: float, sideways: float, tread: float) -> FloatArray:
        """Return the covariance (3, 3) by slip of the motion ahead, to the left, and turn, in [m, m, rad]."""
        length = self._errors.slip_length * self.slip_factor
        slip = self._errors.slip**2 * length
        by_side = np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / tread, 1.0 / tread]])
        rolled = (by_side * (slip * abs(left), slip * abs(right))) @ by_side.T
        across = (self._errors.sideways or SidewaysErrors()).slip ** 2 * length * abs(sideways)
        return np.asarray(rolled + across * np.diag([1.0, 1.0, (2.0 / tread) ** 2]))


def odometry_of(pose: Pose2, tread: float, errors: OdometryErrors, covariance: FloatArray | None) -> Odometry:
    """Return the odometry of a base; a `HolonomicOdometry` if `errors` contains errors of sideways motion.

    Args:
        pose: map_T_base at the start.
        tread: distance of the wheels, in [m].
        errors: errors of the wheels.
        covariance: (3, 3) of the pose, x, y on the map in [m] and heading in [rad]; None: exact.
    """
    kind = Odometry if errors.sideways is None else HolonomicOdometry
    return kind(pose, tread, errors, covariance)


def _twist(forward: float, left: float, turn: float) -> Pose2:
    """Return the motion of a base by constant speeds, in the frame of its start."""
    chord = math.sin(0.5 * turn) / (0.5 * turn) if abs(turn) > 1e-9 else 1.0
    cos, sin = math.cos(0.5 * turn), math.sin(0.5 * turn)
    return Pose2(chord * (cos * forward - sin * left), chord * (sin * forward + cos * left), float(turn))


def _body_jacobian(moved: Pose2, heading: float, turn: float) -> FloatArray:
    """Return the derivative (3, 3) of x, y, heading on the map by motion ahead, to the left, and turn."""
    middle = heading + 0.5 * turn
    cos, sin = math.cos(middle), math.sin(middle)
    x = math.cos(heading) * moved.x - math.sin(heading) * moved.y
    y = math.sin(heading) * moved.x + math.cos(heading) * moved.y
    return np.array([[cos, -sin, -0.5 * y], [sin, cos, 0.5 * x], [0.0, 0.0, 1.0]])
