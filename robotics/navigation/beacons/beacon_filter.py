"""Wheels, gyros and ranges to beacons, by a Kalman filter that finds out each beacon's bias."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.watched_moment import Belief, WatchedMoment
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_localizer import (
    CONSISTENCY_WINDOW,
    FieldLocalizer,
    Inconsistency,
    inconsistency_of,
)
from handcart.robotics.navigation.outdoors.field_model import (
    FieldModel,
    carried,
    corrected,
    field_step,
    level_lever,
)
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .beacon_errors import BeaconErrors

MAX_RANGE_SIGMAS = 5.0  # sigmas within which a range lies that is believed
CARRIED_OFF = 10.0  # [s] for which all ranges to a beacon are rejected: then it was moved
MIN_OTHER_BEACONS = 2  # beacons that are believed meanwhile, at least: else it is the claim that is wrong
NEVER_TIME_S = -CARRIED_OFF  # a time before all others
MIN_BEACON_DISTANCE_M = 0.3  # [m] to a beacon, from which a range gives a direction
BIAS_PERIOD = 1.0  # [s] at rest over which the gyro is averaged into one reading


class BeaconFilter(FieldLocalizer):
    """Extended Kalman filter that localizes a base by wheels, gyro and ranges to radio beacons.

    Besides the pose, the state contains the errors of wheels and gyro (see `FieldModel`), a bias of each
    beacon's ranges and a scale error of all ranges; so these errors are estimated, too (Friedland, 1969).

    Because the start is known, the first ranges determine the biases; later ranges determine the position. A
    range is rejected if it differs from the expected range by more than its covariance allows. If all ranges
    of a beacon are rejected for ten seconds while those of two others are accepted, the beacon was moved. It
    is ignored from then on, because its ranges could later agree with a wrong position. GNSS is not used.
    """

    TAKES_FIXES: ClassVar[bool] = False
    TAKES_RANGES: ClassVar[bool] = True
    STATE: ClassVar[Mapping[str, Any]] = {
        **FieldLocalizer.STATE,
        "_mean": FloatArray,
        "_spread": FloatArray,
        "_rested": bool,
        "_still": FloatArray,
        "_origin": WatchedMoment | None,
        "_clock": float,
        "_squares": list[tuple[float, float | None]],
        "refused": int,
        "_refused_since": FloatArray,
        "_believed_at": FloatArray,
        "_left_out": BoolArray,
    }

    def __init__(
        self, start: Pose2, noise: FieldNoise, errors: BeaconErrors, start_position: float = 0.05
    ) -> None:
        """Start at a pose whose position is right to `start_position` [m] an axis.

        Args:
            start: world_T_base.
            noise: noise model of wheels and gyros.
            errors: error model of the ranges.
            start_position: sigma in [m].
        """
        super().__init__(start)
        self._noise, self._errors = noise, errors
        model, count = FieldModel(noise), len(errors.places)
        self._figures = model.figures
        mean, spread = model.start(np.array(start), start_position)
        own = np.array([errors.bias] * count + [errors.scale])
        self._mean = np.concatenate([mean, np.zeros(count + 1)])
        self._spread = np.diag(np.concatenate([np.zeros(states.STATE_SIZE), own**2]))
        self._spread[: states.STATE_SIZE, : states.STATE_SIZE] = spread
        self._rested = True
        self._still = np.zeros(2)  # turn and time since the gyro's bias was seen, at rest
        self._origin: WatchedMoment | None = None
        self._clock = 0.0
        self._squares: list[tuple[float, float | None]] = []  # times of ranges, and their squares as below
        self.refused = 0
        """Number of ranges that were not believed."""
        self._refused_since = np.full(count, NEVER_TIME_S)  # of those whose last range was refused
        self._believed_at = np.full(count, NEVER_TIME_S)
        self._left_out = np.zeros(count, np.bool_)

    @property
    def biases(self) -> Belief:
        """Estimated range biases (k,) of the beacons, in [m], with their covariance (k, k) in [m²].

        A bias is the measured range minus the true range.
        """
        own = slice(states.STATE_SIZE, -1)
        return Belief(self._mean[own].copy(), self._spread[own, own].copy())

    @property
    @override
    def covariance(self) -> FloatArray:
        return self._spread[:3, :3].copy()

    @property
    @override
    def inconsistency(self) -> Inconsistency | None:
        return inconsistency_of(self._squares, axes=1)

    def _ranges(self, distances: FloatArray) -> None:
        for beacon in np.flatnonzero(np.isfinite(distances) & ~self._left_out).tolist():
            self._take_range(beacon, float(distances[beacon]))

    def _take_range(self, beacon: int, distance: float) -> None:
        expected, row = self._forecast(beacon)
        residual = np.array([distance - expected])
        variance = self._errors.white**2
        square = float(residual[0] ** 2 / ((row @ self._spread @ row.T)[0, 0] + variance))
        believed = square <= MAX_RANGE_SIGMAS**2
        self._squares.append((self._clock, square if believed else None))
        while self._squares[0][0] < self._clock - CONSISTENCY_WINDOW:
            del self._squares[0]
        if believed:
            self._refused_since[beacon], self._believed_at[beacon] = NEVER_TIME_S, self._clock
            self._correct(row, residual, variance)
            return
        self.refused += 1
        if self._refused_since[beacon] == NEVER_TIME_S:
            self._refused_since[beacon] = self._clock
        fits = self._clock - self._believed_at < CARRIED_OFF
        fits[beacon] = False
        long = self._clock - self._refused_since[beacon] >= CARRIED_OFF
        self._left_out[beacon] = long and fits.sum() >= MIN_OTHER_BEACONS

    def _forecast(self, beacon: int) -> tuple[float, FloatArray]:
        """Return the expected range in [m], and its derivative (1, n) by the states."""
        lever = level_lever(self._errors.tag, self.tilt, float(self._mean[states.HEADING]))
        x, y, height = self._errors.places[beacon].tolist()
        away = np.array([x, y]) - self._mean[:2] - lever
        distance = math.hypot(*away, height - self._errors.tag[2])
        scale = 1.0 + float(self._mean[-1])
        row = np.zeros((1, len(self._mean)))
        if distance > MIN_BEACON_DISTANCE_M:
            row[0, [states.X, states.Y]] = -scale * away / distance
            row[0, states.HEADING] = scale * (away[0] * lever[1] - away[1] * lever[0]) / distance
        row[0, states.STATE_SIZE + beacon], row[0, -1] = 1.0, distance
        return scale * distance + float(self._mean[states.STATE_SIZE + beacon]), row

    def _correct(self, rows: FloatArray, residual: FloatArray, variance: float) -> None:
        if self._origin is not None:
            self._origin = self._origin.corrected(self._spread, rows, residual, variance)
        self._mean, self._spread = corrected(self._mean, self._spread, rows, residual, variance)

    def _advance(self, advance: Advance) -> None:
        size = states.STATE_SIZE
        if advance.rest < advance.time:
            self._see_gyro_bias()
        new_leg = self._rested and advance.rest < advance.time
        mean, step, added = field_step(self._mean[:size], np.array(advance), new_leg, self._figures)
        self._mean = np.concatenate([mean, self._mean[size:]])
        transition = np.eye(len(self._mean))
        transition[:size, :size] = step
        walked = np.full(len(self._mean) - size - 1, self._errors.bias_walk**2 * advance.time)
        self._spread = carried(self._spread, transition, np.concatenate([added, walked, [0.0]]))
        if self._origin is not None:
            self._origin = self._origin.stepped(transition)
        self._rested = advance.rest > 0.0
        self._clock += advance.time
        self._still = self._still + np.array([advance.still, advance.rest])
        if self._still[1] >= BIAS_PERIOD:
            self._see_gyro_bias()

    def _see_gyro_bias(self) -> None:
        """Correct the bias of the vertical gyro by its readings at rest, which are nothing but the bias."""
        turned, time = self._still.tolist()
        if time <= 0.0:
            return
        row = np.zeros((1, len(self._mean)))
        row[0, [states.BIAS, states.WARM_UP]] = 1.0
        residual = turned / time - self._mean[states.BIAS] - self._mean[states.WARM_UP]
        self._correct(row, np.array([residual]), self._noise.gyro_white**2 / time)
        self._still = np.zeros(2)

    def _fix(self, position: FloatArray, sigma: float | None) -> bool:
        return False

    def _set_origin(self) -> None:
        self._origin = WatchedMoment.of(Belief(self._mean, self._spread), states=3)

    def _relative_pose(self) -> Belief:
        assert self._origin is not None
        return self._origin.relative_pose(Belief(self._mean, self._spread))

    def _estimate(self) -> Pose2:
        x, y, heading = self._mean[:3].tolist()
        return Pose2(x, y, wrap(heading))
