"""Odometry of a differential drive, with an honest covariance."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.small_solve import lapack_solved

from .bent_way import BentWay
from .watched_moment import Belief, WatchedMoment

_IDENTITY = np.eye(3)
_LEAST = 1e-12 * _IDENTITY  # [m², rad²] of a pose that is certain: it can be divided by


class SidewaysErrors(NamedTuple):
    """Standard deviations of the errors of sideways motion on mecanum, omni or swerve wheels."""

    scale: float = 0.05
    """Relative error of the distance sideways, and of the motion ahead that goes with it; constant."""
    turn: float = 0.05
    """Turn that goes with each metre sideways, in [rad/m]; constant."""
    slip: float = 0.04
    """Relative error of the distance sideways, new every `OdometryErrors.slip_length`."""


class OdometryErrors(NamedTuple):
    """Standard deviations of the errors of a base's wheels; by default those of uncalibrated wheels."""

    radius: float = 0.02
    """Relative error of each wheel's radius, constant."""
    tread: float = 0.02
    """Relative error of the distance between the wheels, constant."""
    slip: float = 0.02
    """Relative error of each wheel's travel, new every `slip_length`."""
    slip_length: float = 0.1
    """Distance after which the slip is new, in [m]."""
    sideways: SidewaysErrors | None = None
    """Errors of sideways motion; None for a base that cannot drive sideways."""


class Odometry:
    """Odometry of a differential drive, which estimates its pose by the travel of its wheels.

    Errors of wheel radii and tread are constant during a drive, so their effect grows with the distance, not
    with its square root. They are therefore three more estimated states. A pose that another sensor measured
    (`correct`) improves them too, so the wheels are calibrated while driving. On long drives the error of the
    heading is not small, so the covariance also includes its second-order effects (`BentWay`).
    """

    STATE: ClassVar = {
        "pose": Pose2,
        "_scales": FloatArray,
        "_state": FloatArray,
        "_origin": WatchedMoment,
        "_bent": BentWay,
    }
    """Attributes that change, with their types."""

    def __init__(
        self,
        pose: Pose2,
        tread: float,
        errors: OdometryErrors = OdometryErrors(),
        covariance: FloatArray | None = None,
    ) -> None:
        """Start at a pose.

        Args:
            pose: map_T_base.
            tread: distance between the wheels, in [m].
            errors: of the wheels.
            covariance: (3, 3) of the pose, in [m, m, rad]; certain if None.
        """
        self.tread = tread
        """Distance between the wheels, in [m]."""
        self._errors = errors
        self.slip_factor = 1.0
        """Factor of the slip's variance relative to `errors`."""
        constants = self._constant_sigmas(errors)
        self._bent = BentWay.straight()
        self._scales = np.zeros(len(constants))  # relative: left travel, right travel, tread
        self._state = np.diag([0.0, 0.0, 0.0, *(sigma**2 for sigma in constants)])
        shared = np.zeros((3, 3 + len(constants)))
        self._origin = WatchedMoment(Belief(np.array(pose), np.zeros((3, 3))), shared)
        self.reset(pose, covariance)
        self.set_origin()

    @staticmethod
    def _constant_sigmas(errors: OdometryErrors) -> tuple[float, ...]:
        """Return the sigmas of the errors that stay the same: the states after those of the pose."""
        return errors.radius, errors.radius, errors.tread

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of the pose's x, y in [m] and heading in [rad], in the map frame."""
        return self._state[:3, :3].copy()

    def set_origin(self) -> None:
        """Set the present pose as the origin, from which `displacement` is measured."""
        mean, state = np.array(self.pose), self._state[:3].copy()
        self._origin = WatchedMoment(Belief(mean, state[:, :3].copy()), state)

    @property
    def origin(self) -> Pose2:
        """Estimate of map_T_base when `set_origin` was called, from which `displacement` is measured."""
        return Pose2(*self._origin.belief.mean.tolist())

    @property
    def displacement(self) -> Belief:
        """Motion since `set_origin` in x, y [m] and heading [rad], in the frame that the base had then.

        The result has a mean (3,) and a covariance (3, 3). Later corrections do not change the pose at the
        origin, to which the robot may have to drive back. An error of the wheel radius cancels on a drive out
        and back.
        """
        heading = self._origin.belief.mean[2] + wrap(float(self.pose.theta - self._origin.belief.mean[2]))
        now = Belief(np.array([self.pose.x, self.pose.y, heading]), self._state[:3, :3])
        return self._origin.relative_pose(now)

    def reset(self, pose: Pose2, covariance: FloatArray | None = None) -> None:
        """Set the pose; keep the calibration of the wheels.

        Args:
            pose: map_T_base.
            covariance: (3, 3) of x, y on the map in [m] and heading in [rad]; None: exact.
        """
        self.pose = pose
        self._state[:3] = 0.0
        self._state[:, :3] = 0.0
        self._origin.shared[:, :3] = 0.0
        self._bent = BentWay.straight()
        if covariance is not None:
            self._state[:3, :3] = covariance

    def shift(self, pose: Pose2, added: FloatArray) -> None:
        """Set a pose to which the base was moved without its wheels; errors of earlier poses remain in the
        covariance.

        Args:
            pose: map_T_base.
            added: (3, 3) covariance of the shift: x, y on the map in [m] and heading in [rad].
        """
        self.pose = pose
        self._state[:3, :3] += added

    def measure_displacement(self, displacement: Pose2, covariance: FloatArray) -> None:
        """Set the pose by a measurement of the motion since `set_origin`; keep the calibration of the wheels.

        Args:
            displacement: origin_T_base.
            covariance: (3, 3) of x, y in [m] and heading in [rad], in the frame of the origin.
        """
        then, spread = self.origin, self._origin.belief.covariance[:3, :3]
        self.reset(then.compose(displacement))
        cos, sin = math.cos(then.theta), math.sin(then.theta)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        x, y = self.pose.x - then.x, self.pose.y - then.y
        carry = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
        self._state[:3, :3] = carry @ spread @ carry.T + turn @ covariance @ turn.T
        self._origin.shared[:, :3] = spread @ carry.T

    def predict(self, left: float, right: float, sideways: float = 0.0) -> None:
        """Move the pose by the travel of the wheels since the last call.

        Args:
            left: travel of the left wheel, in [m].
            right: travel of the right wheel, in [m].
            sideways: travel to the left of a base that drives sideways, in [m].
        """
        if left == 0.0 and right == 0.0:
            self.pose = self.pose._replace(theta=wrap(self.pose.theta))
            return
        left_scale, right_scale, tread_scale = self._scales.tolist()
        moved_left, moved_right = left * (1.0 + left_scale), right * (1.0 + right_scale)
        tread = self.tread * (1.0 + tread_scale)
        forward, turn = 0.5 * (moved_left + moved_right), (moved_right - moved_left) / tread
        heading = self.pose.theta + 0.5 * turn
        chord = forward * (math.sin(0.5 * turn) / (0.5 * turn) if abs(turn) > 1e-9 else 1.0)
        cos, sin = math.cos(heading), math.sin(heading)
        (lx, rx), (ly, ry), (lt, rt) = rows = _wheel_jacobian(forward, cos, sin, tread)
        by_wheel = np.array(rows)
        step = np.array(
            [
                [1.0, 0.0, -chord * sin, lx * left, rx * right, 0.5 * forward * sin * turn],
                [0.0, 1.0, chord * cos, ly * left, ry * right, -0.5 * forward * cos * turn],
                [0.0, 0.0, 1.0, lt * left, rt * right, -1.0 * turn],
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            ]
        )
        before = float(self._state[2, 2])
        self._state = step @ self._state @ step.T
        self._origin = self._origin.stepped(step)
        slip, length = self._errors.slip**2 * self.slip_factor, self._errors.slip_length
        slips = np.array([slip * abs(left) * length, slip * abs(right) * length])
        self._state[:3, :3] += (by_wheel * slips) @ by_wheel.T
        self._bend(chord * cos, chord * sin, before, float(slips.sum()) / tread**2)
        self.pose = self.pose.compose(_arc(chord, turn))

    def _bend(self, x: float, y: float, before: float, slip: float) -> None:
        """Add to the covariance what a step adds beyond its first order.

        Args:
            x: of the step on the map, in [m].
            y: of the step on the map, in [m].
            before: variance of the heading before the step, in [rad²].
            slip: part of the heading's variance that the step has added, in [rad²].
        """
        bent = self._bent.stepped(x, y, _middle(before, float(self._state[2, 2])), slip)
        self._state[:2, :2] += bent.covariance - self._bent.covariance
        self._bent = bent

    def correct(self, pose: Pose2, covariance: FloatArray, kept: FloatArray | None = None) -> None:
        """Correct the pose by a better estimate, for which the present pose was used as prior.

        Args:
            pose: map_T_base.
            covariance: (3, 3) of the better estimate: x, y on the map in [m] and heading in [rad].
            kept: (3, 3) matrix that maps the prior's error, along the same axes, to the error that remains:
                identity less the gain. None: that of an optimal filter with this covariance.
        """
        prior = self._state[:3, :3] + _LEAST
        gain = lapack_solved(prior, self._state[:3]).T  # (6, 3): effect of a change of the pose on all states
        turn = wrap(float(pose.theta - self.pose.theta))
        change = np.array([pose.x - self.pose.x, pose.y - self.pose.y, turn])
        self._scales += (gain @ change)[3:]
        rest = lapack_solved(prior, covariance).T if kept is None else kept
        lost = self._origin.shared[:, :3] @ (_IDENTITY - rest).T @ gain.T
        self._origin = WatchedMoment(self._origin.belief, self._origin.shared - lost)
        self._state = self._state + gain @ (covariance - prior) @ gain.T
        self._state[:3, :3] = covariance
        self._bent = self._bent.corrected(np.asarray(rest))
        self.pose = pose

    @property
    def errors(self) -> OdometryErrors:
        """Standard deviations of the wheels' errors, as assumed at the start."""
        return self._errors

    def sideways_turn_variance(self, sideways: float) -> float:
        """Return the variance of the heading, in [rad²], that is caused by slip while the base drives
        sideways.

        It is 0 here; odometry of bases that drive sideways overrides the method.

        Args:
            sideways: sideways travel, in [m].
        """
        return 0.0

    def turn_variance(self, left: float, right: float, sideways: float = 0.0) -> float:
        """Return the variance, in [rad²], of the turn computed from wheel travel, by constant errors of the
        wheels.

        Arguments are travel in [m]; `sideways` is positive to the left. Slip is not included.
        """
        by_scale = np.array([-left, right, -(right - left)]) / self.tread
        return float(by_scale @ self._state[3:6, 3:6] @ by_scale)

    @property
    def scale_variance(self) -> float:
        """Variance of the relative error of the length that wheel odometry computes for a straight path,
        without unit.
        """
        return float(self._state[3:5, 3:5].sum()) / 4.0

    def doubt_scale(self, size: float) -> None:
        """Increase the variance of both wheels' radii, because lengths were found to have a relative error
        `size`.
        """
        self._state[3:5, 3:5] += size**2


def _middle(before: float, after: float) -> float:
    """Return the variance half way between two, of an error that grows in proportion to the way."""
    return 0.25 * (math.sqrt(max(0.0, before)) + math.sqrt(max(0.0, after))) ** 2


def _wheel_jacobian(
    forward: float, cos: float, sin: float, tread: float
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Return the rows of x, y, heading by the travel of the left and the right wheel."""
    bend = 0.5 * forward / tread
    return (
        (0.5 * cos + bend * sin, 0.5 * cos - bend * sin),
        (0.5 * sin - bend * cos, 0.5 * sin + bend * cos),
        (-1.0 / tread, 1.0 / tread),
    )


def _arc(chord: float, turn: float) -> Pose2:
    """Return the end of an arc with this chord and turn, in the frame of its start."""
    return Pose2(float(chord) * math.cos(0.5 * turn), float(chord) * math.sin(0.5 * turn), float(turn))
