"""Linear model of an outdoor robot's errors, shared by Kalman filter, smoother and information limit."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_CURVATURE, FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled
from handcart.robotics.numerics.small_solve import solved

X, Y, HEADING, SCALE, TURN_SLIP, SLIP, SIDE, BIAS, WARM_UP, GYRO_SCALE, GPS_X, GPS_Y, DELAY = range(13)
STATE_SIZE = 13
TILT_SIGMA_RAD = math.radians(0.17)  # error of an ordinary levelled accelerometer


class FieldModel(NamedTuple):
    """Model of a base outdoors, by thirteen states that change with the readings of wheels and gyro.

    The states are, in this order: x and y in the field's frame in [m]; heading in [rad]; relative error of
    the wheels' travel, in three parts: constant, in curves (new after each change of the driving direction),
    and slowly changing; angle from the heading to the direction of travel in [rad]; the vertical gyro's bias
    in [rad/s], the part of it that decays as the gyro warms up, and its relative scale error; slow error of
    the fixes in x and y in [m]; delay of the fixes in [s].
    """

    noise: FieldNoise
    tilt: float = TILT_SIGMA_RAD
    """Sigma of the estimated roll and pitch, in [rad], which displaces the antenna."""

    def start(self, pose: FloatArray, position_sigma: float) -> tuple[FloatArray, FloatArray]:
        """Return mean (13,) and covariance (13, 13) of the states before the first reading, in SI units.

        Args:
            pose: (3,) field_T_base: x, y in [m], heading in [rad].
            position_sigma: standard deviation of x and of y, in [m].
        """
        noise = self.noise
        mean = np.zeros(STATE_SIZE)
        mean[:3] = pose
        sigmas = np.zeros(STATE_SIZE)
        sigmas[[X, Y]] = position_sigma
        sigmas[HEADING] = noise.start_heading
        sigmas[SCALE], sigmas[SLIP], sigmas[TURN_SLIP] = noise.scale, noise.slip, noise.turn_slip
        sigmas[SIDE], sigmas[BIAS], sigmas[WARM_UP] = noise.side_slip, noise.gyro_bias, noise.gyro_warm_up
        sigmas[GYRO_SCALE] = noise.gyro_scale
        sigmas[[GPS_X, GPS_Y]], sigmas[DELAY] = self._drift, noise.gps_delay
        return mean, np.diag(sigmas**2)

    @property
    def figures(self) -> FloatArray:
        """Parameters (11,) of the noise model in SI units, in the order that `field_step` expects.

        They are these attributes of the model's `noise`: `slip`, `slip_length`, `turn_slip`, `side_slip`,
        `side_slip_length`, `side_slip_turning`, `gyro_white`, `gyro_walk`, `gyro_warm_up_time`; then the
        standard deviation of a fix's slow error in [m], and the attribute `gps_drift_time`.
        """
        n = self.noise
        ground = [n.slip, n.slip_length, n.turn_slip, n.side_slip, n.side_slip_length, n.side_slip_turning]
        gyro = [n.gyro_white, n.gyro_walk, n.gyro_warm_up_time]
        return np.array([*ground, *gyro, self._drift, n.gps_drift_time])

    def step(
        self, mean: FloatArray, advance: Advance, new_leg: bool
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the predicted mean (13,), transition matrix (13, 13) and added variances (13,) of a step, in
        SI units.

        Args:
            mean: (13,) states before the step, in the order that `FieldModel` lists.
            advance: motion in the step.
            new_leg: True if the base changed its direction of driving.
        """
        out: tuple[FloatArray, FloatArray, FloatArray] = field_step(
            mean, np.array(advance), new_leg, self.figures
        )
        return out

    @property
    def _drift(self) -> float:
        """Slow error of a fix, in [m]."""
        return math.hypot(self.noise.gps_drift, self.tilt * self.noise.antenna[2])


@compiled
def field_step(
    mean: FloatArray, advance: FloatArray, new_leg: bool, figures: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the predicted mean (13,), transition matrix (13, 13) and added variances (13,) of
    `FieldModel.step`.

    The covariance after the step is transition @ covariance @ transition.T + diag(added).

    Args:
        mean: (13,) states before the step, in SI units.
        advance: (6,) fields of an `Advance`: travel forward in [m]; turn, and the turn by the known gyro
            bias, in [rad]; duration, and its part at rest, in [s]; turn measured by the gyro at rest in
            [rad].
        new_leg: True if the base changed its direction of driving.
        figures: (11,) parameters of the noise in SI units, in the order of `FieldModel.figures`.
    """
    forward, turn, drift, time, rest, _ = advance
    slip, slip_length, turn_slip, side, side_length, side_turning = figures[:6]
    white, walk, warm_up_time, gps, gps_time = figures[6:]
    mean = mean.copy()
    transition = np.eye(13)
    added = np.zeros(13)
    moving = time - rest
    if new_leg:
        mean[4], transition[4, 4], added[4] = 0.0, 0.0, turn_slip**2
    if forward != 0.0 or moving > 0.0:
        read = turn + drift - (mean[7] + mean[8]) * moving
        bent = read * (1.0 - mean[9])
        bend = min(0.6, max(-0.6, bent / forward)) if abs(forward) > 1e-3 else 0.0
        curve = abs(bend) / REFERENCE_CURVATURE
        slipped = max(0.2, 1.0 + mean[3] + mean[4] * curve + mean[5])
        way = forward / slipped
        course = mean[2] + 0.5 * bent + mean[6] + side_turning * bend
        cos, sin = math.cos(course), math.sin(course)
        mean[0] += way * cos
        mean[1] += way * sin
        mean[2] += bent
        for column, share in ((3, 1.0), (4, curve), (5, 1.0)):
            transition[0, column] = -way / slipped * share * cos
            transition[1, column] = -way / slipped * share * sin
        if new_leg:
            transition[0, 4], transition[1, 4] = 0.0, 0.0
        for column, by_turn, by_course in ((2, 0.0, 1.0), (6, 0.0, 1.0), (7, -moving, -0.5 * moving)):
            transition[0, column] = -way * sin * by_course
            transition[1, column] = way * cos * by_course
            transition[2, column] += by_turn
        transition[:3, 8] = transition[:3, 7]
        transition[2, 9] = -read
        transition[0, 9], transition[1, 9] = 0.5 * way * sin * read, -0.5 * way * cos * read
        added[2] += white**2 * moving
        for state, length, sigma in ((5, slip_length, slip), (6, side_length, side)):
            keep = math.exp(-abs(forward) / length)
            mean[state] *= keep
            transition[state, state] = keep
            added[state] += sigma**2 * (1.0 - keep * keep)
    keep = math.exp(-time / warm_up_time)
    mean[8] *= keep
    transition[8, 8] = keep
    added[7] += walk**2 * time
    keep = math.exp(-time / gps_time)
    for state in (10, 11):
        mean[state] *= keep
        transition[state, state] = keep
        added[state] += gps**2 * (1.0 - keep * keep)
    return mean, transition, added


@compiled
def went_on(
    mean: FloatArray, covariance: FloatArray, advance: FloatArray, new_leg: bool, figures: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mean (13,) and covariance (13, 13) after a step of `FieldModel`, and its transition matrix (13,
    13).

    Args:
        mean: (13,) states before the step, in SI units.
        covariance: (13, 13) of the states before the step, in SI units.
        advance: (6,) fields of an `Advance`: travel forward in [m]; turn, and the turn by the known gyro
            bias, in [rad]; duration, and its part at rest, in [s]; turn measured by the gyro at rest in
            [rad].
        new_leg: True if the base changed its direction of driving.
        figures: (11,) parameters of the noise in SI units, in the order of `FieldModel.figures`.
    """
    mean, transition, added = field_step(mean, advance, new_leg, figures)
    return mean, carried(covariance, transition, added), transition


@compiled
def level_lever(antenna: tuple[float, float, float], tilt: tuple[float, float], heading: float) -> FloatArray:
    """Return the horizontal offset (2,) from the base to its antenna, in the field's axes, in [m].

    Args:
        antenna: x, y, z of the antenna in the base frame, in [m].
        tilt: roll and pitch of the base, in [rad].
        heading: heading of the base, in [rad].
    """
    x, y, z = antenna
    roll, pitch = tilt
    across, up = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
    along = x * math.cos(pitch) + up * math.sin(pitch)
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([cos * along - sin * across, sin * along + cos * across])


@compiled
def fix_forecast(mean: FloatArray, lever: FloatArray, speed: float) -> tuple[FloatArray, FloatArray]:
    """Return the derivative of a GNSS fix by the states of `FieldModel`, and the fix's expected value.

    Args:
        mean: (13,) states, in SI units.
        lever: (2,) horizontal offset from the base to the antenna, in the field's axes, in [m].
        speed: speed of the base, in [m/s].

    Returns:
        Derivatives (2, 13) of the antenna's position by the states, and this position (2,) in the field's
            frame, in [m].
    """
    cos, sin = math.cos(mean[HEADING]), math.sin(mean[HEADING])
    rows = np.zeros((2, STATE_SIZE))
    rows[0, X] = rows[0, GPS_X] = rows[1, Y] = rows[1, GPS_Y] = 1.0
    rows[0, HEADING], rows[1, HEADING] = -lever[1], lever[0]
    rows[0, DELAY], rows[1, DELAY] = -speed * cos, -speed * sin
    expected = np.empty(2)
    for axis, states in ((0, (X, GPS_X)), (1, (Y, GPS_Y))):
        at, error = states
        expected[axis] = mean[at] + mean[error] + rows[axis, DELAY] * mean[DELAY] + lever[axis]
    return rows, expected


@compiled
def carried(covariance: FloatArray, transition: FloatArray, added: FloatArray) -> FloatArray:
    """Return the covariance (13, 13) of the states of `FieldModel` after a step, in SI units squared.

    Args:
        covariance: (13, 13) of the states before the step, in SI units.
        transition: (13, 13) derivative of the states after the step by the states before it.
        added: (13,) variances that the step adds, in SI units.
    """
    out = transition @ covariance @ transition.T
    for i in range(len(added)):
        out[i, i] += added[i]
    return out


@compiled
def corrected(
    mean: FloatArray, covariance: FloatArray, rows: FloatArray, residual: FloatArray, variance: float
) -> tuple[FloatArray, FloatArray]:
    """Return mean (13,) and covariance (13, 13) of the states of `FieldModel` after readings, in SI units.

    The update uses Joseph's form, which keeps the covariance positive.

    Args:
        mean: (13,) states, in SI units.
        covariance: (13, 13) of the states, in SI units.
        rows: (m, 13) derivative of the readings by the states.
        residual: (m,) readings less their forecast, in their unit.
        variance: variance of each reading, in its unit squared.
    """
    spread = covariance @ rows.T
    seen = rows @ spread
    for i in range(len(residual)):
        seen[i, i] += variance
    gain = solved(seen, spread.T).T
    left = np.eye(len(mean)) - gain @ rows
    after = left @ covariance @ left.T + variance * (gain @ gain.T)
    return mean + gain @ residual, 0.5 * (after + after.T)
