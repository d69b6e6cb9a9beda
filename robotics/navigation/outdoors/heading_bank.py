"""Search for an unknown start heading: a Kalman filter for each of many headings."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.watched_moment import Belief, spread_about
from handcart.robotics.navigation.outdoors.field_model import (
    BIAS,
    HEADING,
    STATE_SIZE,
    WARM_UP,
    FieldModel,
    corrected,
    fix_forecast,
    level_lever,
    went_on,
)
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.navigation.outdoors.sky import log_normal
from handcart.robotics.numerics.arrays import FloatArray

HEADING_COUNT = 36
KNOWN_HEADING_SIGMA_RAD = math.radians(4.0)  # sigma of a heading that is known well enough to lay sensors by
REFLECTED_SHARE = 0.05  # of the fixes
REFLECTED_M = 10.0  # [m] an axis, how far those are off
SURPRISE_SHARE = 1e-3  # share of all headings that stay possible after each fix: fixes may be off together
MIN_FIXES = 6  # before a heading counts as known
LEAST_DRIFT = 0.75  # of a fix's white error: the slow error that is supposed at least
LEAST_DRIFT_TIME_S = 60.0  # over which that changes
MISFIT_MEMORY_FIXES = 10.0  # fixes over which the share of those that fit no heading is averaged
MAX_ODD = 0.6  # of that share: above it odometry was wrong at some time, and the search starts again
_BIAS_ROW = np.array([[1.0 if state in (BIAS, WARM_UP) else 0.0 for state in range(STATE_SIZE)]])


class HeadingBank:
    """Estimator of an unknown heading by several Kalman filters, weighted by the fixes' likelihoods (Magill,
    1965).

    The filters start with headings in all directions. Each estimates all states of `FieldModel`, so that also
    a slow error of the fixes, a gyro's bias, slip of the wheels and late fixes are taken into account. Until
    the heading is known, the base's pose is that of the weighted mixture of all filters, which is near the
    middle of the fixes.
    """

    STATE: ClassVar = {
        "_weights": FloatArray,
        "_means": FloatArray,
        "_spreads": FloatArray,
        "_rested": bool,
        "_fixes": int,
        "_speed": float,
        "_odd": float,
    }
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, start: Pose2, noise: FieldNoise, start_position: float) -> None:
        """Begin at a place, with any heading.

        Fixes without any slow error would be believed too much, because where one jumps, nothing else shows
        it yet: at least `LEAST_DRIFT` of their white error is assumed.

        Args:
            start: world_T_base; its heading is the first one that is tried.
            noise: noise model of wheels, gyros and GPS.
            start_position: sigma of the position along each axis, in [m].
        """
        self._noise = noise
        supposed = noise._replace(start_heading=0.6 * 2.0 * math.pi / HEADING_COUNT)
        if noise.gps_drift < LEAST_DRIFT * noise.gps_white:
            supposed = supposed._replace(
                gps_drift=LEAST_DRIFT * noise.gps_white, gps_drift_time=LEAST_DRIFT_TIME_S
            )
        self._model = FieldModel(supposed)
        self._figures = self._model.figures
        self.begin(start, start_position)

    def begin(self, start: Pose2, start_position: float) -> None:
        """Restart the filters at a known place with an unknown heading, which is tried in all directions.

        Args:
            start: world_T_base; the first filter starts with its heading, the others with headings at even
                angles from it.
            start_position: standard deviation of the position along each axis, in [m].
        """
        turn = 2.0 * math.pi / HEADING_COUNT
        mean, spread = self._model.start(np.array(start), start_position)
        self._means = np.tile(mean, (HEADING_COUNT, 1))
        self._means[:, 2] += turn * np.arange(HEADING_COUNT)
        self._spreads = np.tile(spread, (HEADING_COUNT, 1, 1))
        self._weights = np.full(HEADING_COUNT, 1.0 / HEADING_COUNT)
        self._rested, self._fixes, self._speed, self._odd = True, 0, 0.0, 0.0

    @property
    def belief(self) -> Belief:
        """Mean (13,) and covariance (13, 13) of the states of `FieldModel`, mixed from all filters, in SI
        units.

        The mean heading is not wrapped; it is within pi of the most likely filter's heading.
        """
        best = self._means[int(np.argmax(self._weights))]
        away = self._means - best
        away[:, 2] = (away[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
        mean = self._weights @ away
        return Belief(best + mean, spread_about(away - mean, self._weights, self._spreads, self._weights))

    @property
    def pose(self) -> Pose2:
        """Pose world_T_base of the mixture; its heading is not usable until it is known (`is_known`)."""
        x, y, heading = self.belief.mean[:3].tolist()
        return Pose2(x, y, wrap(heading))

    def is_known(self, sigma: float) -> bool:
        """Return whether the heading's standard deviation is at most `sigma`, in [rad], after at least
        `MIN_FIXES` fixes.
        """
        if self._fixes < MIN_FIXES or self._odd > 0.5 * MAX_ODD:
            return False
        return float(self.belief.covariance[2, 2]) <= sigma**2

    def advance(self, advance: Advance) -> None:
        """Predict the filters of all assumed headings by one step of wheels and gyros.

        While the base rests, the estimate of the gyro's bias is corrected by the gyro's readings.
        """
        new_leg = self._rested and advance.rest < advance.time
        self._rested = advance.rest > 0.0
        self._speed = advance.forward / advance.time
        step = np.array(advance)
        for k in range(HEADING_COUNT):
            mean, spread, _ = went_on(self._means[k], self._spreads[k], step, new_leg, self._figures)
            if advance.rest > 0.0:  # the vertical gyro reads nothing but its bias
                residual = np.array([advance.still / advance.rest - mean[BIAS] - mean[WARM_UP]])
                white = self._noise.gyro_white**2 / advance.rest
                mean, spread = corrected(mean, spread, _BIAS_ROW, residual, white)
            self._means[k], self._spreads[k] = mean, spread

    def fix(self, position: FloatArray, sigma: float, odometry: GyroOdometry) -> float:
        """Update all filters with a GNSS fix, and return the logarithm of its likelihood.

        If most of the latest fixes are implausible for all headings, all filters start again at this fix.

        Args:
            position: (2,) position of the antenna in the field's frame, in [m].
            sigma: standard deviation of the fix's white noise along each axis, in [m].
            odometry: pose by wheels and gyros alone, used for the tilt.
        """
        variance = sigma**2
        if not odometry.levelled:
            variance += (self._noise.antenna[2] * self._noise.roughness) ** 2
        likely, odd = np.empty(HEADING_COUNT), np.zeros(HEADING_COUNT)
        for k in range(HEADING_COUNT):
            lever = level_lever(self._noise.antenna, odometry.tilt, float(self._means[k, HEADING]))
            self._means[k], self._spreads[k], likely[k], odd[k] = _corrected_by(
                self._means[k], self._spreads[k], position, variance, lever, self._speed
            )
        joint = np.log(self._weights) + likely
        most = float(joint.max())
        weights = np.exp(joint - most)
        total = float(weights.sum())
        self._weights = (1.0 - SURPRISE_SHARE) * weights / total + SURPRISE_SHARE / HEADING_COUNT
        self._fixes += 1
        self._odd += (float(self._weights @ odd) - self._odd) / MISFIT_MEMORY_FIXES
        if self._odd > MAX_ODD:
            lever = level_lever(self._noise.antenna, odometry.tilt, self.pose.theta)
            x, y = (position - lever).tolist()
            self.begin(Pose2(x, y, self.pose.theta), 3.0 * sigma)
        return most + math.log(total)


def _corrected_by(
    mean: FloatArray,
    spread: FloatArray,
    position: FloatArray,
    variance: float,
    lever: FloatArray,
    speed: float,
) -> tuple[FloatArray, FloatArray, float, bool]:
    """Return mean (13,) and covariance (13, 13) after a fix, its log-likelihood, and True for a reflection.

    A fix that is likelier a reflection counts as one of that size: it draws the filter but little.
    """
    rows, expected = fix_forecast(mean, lever, speed)
    residual = position - expected
    whole = rows @ spread @ rows.T + variance * np.eye(2)
    good = log_normal(residual, whole) + math.log(1.0 - REFLECTED_SHARE)
    bad = log_normal(residual, whole + REFLECTED_M**2 * np.eye(2)) + math.log(REFLECTED_SHARE)
    used = variance if good >= bad else variance + REFLECTED_M**2
    return *corrected(mean, spread, rows, residual, used), float(np.logaddexp(good, bad)), bad > good
