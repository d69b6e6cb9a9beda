"""A Kalman filter of wheels, gyros and GPS with one noise model of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.watched_moment import (
    Belief,
    BeliefBranch,
    WatchedMoment,
    mixed,
)
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_model import (
    FieldModel,
    corrected,
    fix_forecast,
    level_lever,
    went_on,
)
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.navigation.outdoors.sky import Sky, leapt, log_normal
from handcart.robotics.navigation.outdoors.smoothing import Entries, TrackRecord
from handcart.robotics.numerics.arrays import FloatArray

from .filter_history import FilterMoment, FilterRequest, FixResult
from .fix_monitor import MAX_TESTED_FIXES, FixMonitor, whitened
from .lost_track import FoundTrack, LostTrack

LOG_REFLECTION_SHARE = math.log(0.001)  # logarithm of the share of fixes that begin to lie anywhere
ODD_STILL = math.log(0.95)  # likewise for fixes that stay where the one before was
REFLECTION_SIGMA_M = 10.0  # [m] an axis, how far off they are
# logarithm of how likely it is that a filter that is right has to start again
LOG_RESTART_PROBABILITY = -20.0
REFLECTION_MEMORY_FIXES = 4.0  # of the latest of them, which predict the next one
BIAS_PERIOD = 1.0  # [s] at rest over which the gyro is averaged into one reading
MIN_LOG_SHARE = math.log(1e-4)  # of what fixes' error may have done: less likely than that does not count
LEAST_TIME = 0.1  # [s] minimum duration of a leap of fixes, used if there is no step between two of them
_BIAS_ROW = np.array([[1.0 if k in (states.BIAS, states.WARM_UP) else 0.0 for k in range(states.STATE_SIZE)]])
_LEAPT = np.diag([0.0 if k in (states.GPS_X, states.GPS_Y) else 1.0 for k in range(states.STATE_SIZE)])


class FieldKalman:
    """Extended Kalman filter for the pose of a base outdoors, by wheels, gyros and GNSS fixes.

    The errors of wheels, gyros and fixes are states of the filter too (see `FieldModel`).

    A fix is rejected if it differs from the expected position by more than the covariances allow. A series of
    fixes with a common error is rejected as well; fixes of the series that were accepted before are undone
    (see `FixMonitor`). If rejected fixes agree with each other and with the odometry, the filter is assumed
    to be wrong, and starts again from these fixes (see `LostTrack`). A reading that isn't finite is ignored.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        "_mean": FloatArray,
        "_spread": FloatArray,
        "_rested": bool,
        "_still": FloatArray,
        "_speed": float,
        "_unseen": float,
        "_lost": LostTrack,
        "_monitor": FixMonitor,
        "_past": list[tuple[FilterMoment, list[Advance | FilterRequest]]],
        "_refused": FloatArray,
        "_record": TrackRecord | None,
        "_origin": WatchedMoment | None,
        "refused": int,
        "restarts": int,
    }

    def __init__(
        self,
        start: Pose2,
        noise: FieldNoise = REFERENCE_NOISE,
        start_position: float = 0.05,
        record: TrackRecord | None = None,
    ) -> None:
        """Start at a pose whose position is right to `start_position` [m] an axis.

        Args:
            start: world_T_base.
            noise: noise model of wheels, gyros and GNSS.
            start_position: sigma in [m].
            record: recorder of the data that a smoother needs.
        """
        self.noise = noise
        """Noise model of the filter."""
        self._model = FieldModel(noise)
        self._figures = self._model.figures
        self._mean, self._spread = self._model.start(np.array(start), start_position)
        self._rested = True
        self._still = np.zeros(2)  # turn and time since the bias was seen, at rest
        self._speed = 0.0
        self._unseen = 0.0  # [s] since the last fix
        self._lost = LostTrack()
        self._monitor = FixMonitor()
        self._past: list[
            tuple[FilterMoment, list[Advance | FilterRequest]]
        ] = []  # before each believed fix, and what came
        self._refused = np.zeros(3)  # sum (2,) of residuals of refused fixes that are off alike, and how many
        self._record = record
        self._origin: WatchedMoment | None = None  # pose from which `relative_pose` is measured
        self.refused = 0
        """Number of fixes that were not believed."""
        self.restarts = 0
        """Number of restarts of the filter from rejected fixes."""
        if record is not None:
            record.start()

    @property
    def belief(self) -> Belief:
        """Mean (13,) and covariance (13, 13) of all states of `FieldModel`, in SI units."""
        return Belief(self._mean, self._spread)

    def mark(self) -> Belief:
        """Mark the present time, so that `smoothed` estimates the states at this time, and return the present
        belief.
        """
        self._note(FilterRequest.MARK)
        now = Belief(self._mean.copy(), self._spread.copy())
        if self._record is not None:
            self._record.mark(now)
        return now

    def set_origin(self) -> None:
        """Set the present pose as the origin from which `relative_pose` is measured."""
        self._note(FilterRequest.ORIGIN)
        self._origin = WatchedMoment.of(self.belief, states=3)

    @property
    def relative_pose(self) -> Belief:
        """Motion origin_T_base since `set_origin`, with mean (3,) and covariance (3, 3).

        The mean is x, y in [m] and the heading in [rad], which is not wrapped.
        """
        if self._origin is None:
            raise ValueError("no origin was set")
        return self._origin.relative_pose(self.belief)

    def smoothed(self) -> list[Belief]:
        """Return the states at all times that `mark` marked, estimated from all readings so far, also later
        ones.

        The list is empty if the filter keeps no record of its readings.
        """
        return [] if self._record is None else self._record.smoothed()

    @property
    def pose(self) -> Pose2:
        """Estimated pose of the base in the world (world_T_base), in [m] and [rad]."""
        x, y, heading = self._mean[:3].tolist()
        return Pose2(x, y, wrap(heading))

    def advance(self, advance: Advance) -> None:
        """Predict the states after one step, by the motion that wheels and gyros have measured."""
        self._note(advance)
        if advance.rest < advance.time:
            self._see_bias()
        new_leg = self._rested and advance.rest < advance.time
        self._mean, self._spread, transition = went_on(
            self._mean, self._spread, np.array(advance), new_leg, self._figures
        )
        self._rested = advance.rest > 0.0
        self._speed = advance.forward / advance.time
        self._unseen += advance.time
        self._still = self._still + np.array([advance.still, advance.rest])
        self._went_on(transition)
        if self._still[1] >= BIAS_PERIOD:
            self._see_bias()

    def _see_bias(self) -> None:
        """Correct the bias of the vertical gyro by its readings at rest, which are nothing but the bias."""
        turned, time = self._still
        if time <= 0.0:
            return
        residual = turned / time - self._mean[states.BIAS] - self._mean[states.WARM_UP]
        self._correct(_BIAS_ROW, np.array([residual]), self.noise.gyro_white**2 / time)
        self._still = np.zeros(2)

    def fix(self, position: FloatArray, sigma: float | None, odometry: GyroOdometry) -> FixResult:
        """Update with a GNSS position, if it is plausible.

        Args:
            position: (2,) position of the antenna in the field's frame, in [m].
            sigma: standard deviation along each axis, as reported by the receiver, in [m]; None: that of the
                noise model.
            odometry: pose by wheels and gyros alone.
        """
        variance = (self.noise.gps_white if sigma is None else sigma) ** 2
        if not odometry.levelled:
            variance += (self.noise.antenna[2] * self.noise.roughness) ** 2
        lever = level_lever(self.noise.antenna, odometry.tilt, float(self._mean[states.HEADING]))
        rows, expected = fix_forecast(self._mean, lever, self._speed)
        skies = self._skies(rows, position - expected, variance)
        likely = float(np.logaddexp.reduce([sky.log_likelihood for sky in skies]))
        skies = [sky for sky in skies if sky.log_likelihood > likely + MIN_LOG_SHARE]
        _, _, residual, whole, _ = max(skies, key=lambda sky: sky.log_likelihood)
        white = whitened(residual, whole)
        square = float(white @ white)
        why = "fixes before it were off together: it waits until some in a row are where it expects them"
        if self._monitor.doubting:
            believed = self._monitor.cleared(residual, whole - variance * np.eye(2), variance)
        else:
            suspects = self._monitor.suspects(residual, whole)
            believed = suspects == 0
            if suspects:
                off = f"{math.hypot(*residual):.2f} m off, {math.sqrt(square):.1f} sigma"
                why = off if suspects == 1 else f"the last {suspects} are off together, this one by {off}"
            self._take_back(suspects - 1)
            if suspects > 1 and not math.isinf(self.noise.jump_every):
                return self._leap(position, sigma, odometry)
        self._lost.take(odometry.pose, position - lever, believed)
        if believed:
            self._past.append((self._moment(), []))
            del self._past[:-MAX_TESTED_FIXES]
            self._take_in(skies, rows, variance)
            self._refused = np.zeros(3)
            return FixResult(True, likely, square)
        likelihood = self._reflected(residual, whole)
        self.refused += 1
        if self._start_again(math.sqrt(variance)):
            return FixResult(
                True, likelihood + LOG_RESTART_PROBABILITY, square, "the filter starts again from these fixes"
            )
        return FixResult(False, likelihood, square, why)

    def _leap(self, position: FloatArray, sigma: float | None, odometry: GyroOdometry) -> FixResult:
        """Update with a fix whose error has jumped to any value since the last one, and find that value."""
        self._monitor.reset()
        self._mean, self._spread = _LEAPT @ self._mean, leapt(self._spread, self.noise.jump)
        self._went_on(_LEAPT)
        fixed = self.fix(position, sigma, odometry)
        leaps = LEAST_TIME / self.noise.jump_every
        return fixed._replace(log_likelihood=fixed.log_likelihood + math.log(leaps))

    def _reflected(self, residual: FloatArray, whole: FloatArray) -> float:
        """Return the log-likelihood of a rejected fix, which is off by any value, or by the same as those
        rejected before it.
        """
        anywhere = log_normal(residual, whole + REFLECTION_SIGMA_M**2 * np.eye(2)) + LOG_REFLECTION_SHARE
        alike, (before, count) = -math.inf, (self._refused[:2], float(self._refused[2]))
        if count:
            alike = log_normal(residual - before / count, (1.0 + 1.0 / count) * whole) + ODD_STILL
        fewer = min(1.0, (REFLECTION_MEMORY_FIXES - 1.0) / count) if count else 1.0
        goes_on = fewer * self._refused if alike > anywhere else np.zeros(3)
        self._refused = goes_on + np.append(residual, 1.0)
        return float(np.logaddexp(anywhere, alike))

    def _skies(self, rows: FloatArray, residual: FloatArray, variance: float) -> list[Sky]:
        """Return the possible changes of the fixes' error since the last one; their likelihoods add up to the
        fix's.

        An error may leap: the part of the distance between two fixes that the wheels didn't drive is
        either chance or a leap, and the likelier a leap the faster it would be otherwise.
        """
        same = Sky.of(None, self._spread, rows, residual, variance, 0.0)
        unseen, self._unseen = self._unseen, 0.0
        if math.isinf(self.noise.jump_every):
            return [same]
        leaps = -math.expm1(-max(unseen, LEAST_TIME) / self.noise.jump_every)
        residual = residual + self._mean[[states.GPS_X, states.GPS_Y]]
        other = Sky.of(
            _LEAPT, leapt(self._spread, self.noise.jump), rows, residual, variance, math.log(leaps)
        )
        return [same._replace(log_likelihood=same.log_likelihood + math.log1p(-leaps)), other]

    def _take_in(self, skies: list[Sky], rows: FloatArray, variance: float) -> None:
        """Correct by a fix in each GNSS condition; keep the mixture (first-order generalised
        pseudo-Bayes).
        """
        if len(skies) == 1 and skies[0].transition is None:
            self._correct(rows, skies[0].residual, variance)
            return
        weights = np.exp([sky.log_likelihood for sky in skies])
        weights /= weights.sum()
        means = [self._mean if sky.transition is None else sky.transition @ self._mean for sky in skies]
        each = [
            Belief(*corrected(mean, sky.spread, rows, sky.residual, variance))
            for mean, sky in zip(means, skies, strict=True)
        ]
        branches = [
            BeliefBranch(weight, sky.transition, sky.spread, sky.residual, one.mean)
            for weight, sky, one in zip(weights.tolist(), skies, each, strict=True)
        ]
        if self._record is not None:
            self._record.correct_either(branches, rows, variance)
        if self._origin is not None:
            self._origin = self._origin.corrected_either(branches, rows, variance)
        self._mean, self._spread = mixed(each, weights)

    def _correct(self, rows: FloatArray, residual: FloatArray, variance: float) -> None:
        if self._record is not None:
            self._record.correct(self._spread, rows, residual, variance)
        if self._origin is not None:
            self._origin = self._origin.corrected(self._spread, rows, residual, variance)
        self._mean, self._spread = corrected(self._mean, self._spread, rows, residual, variance)

    def _went_on(self, transition: FloatArray) -> None:
        """Propagate the recorder and the origin's cloned states by `transition` (13, 13)."""
        if self._record is not None:
            self._record.step(transition)
        if self._origin is not None:
            self._origin = self._origin.stepped(transition)

    def _moment(self) -> FilterMoment:
        entries = Entries(0, 0, None) if self._record is None else self._record.entries
        return FilterMoment(
            Belief(self._mean, self._spread), self._rested, self._still, entries, self._origin
        )

    def _note(self, event: Advance | FilterRequest) -> None:
        """Record a step or a request, in case the fixes before it are undone."""
        if self._past:
            self._past[-1][1].append(event)

    def _take_back(self, count: int) -> None:
        """Undo the latest `count` accepted fixes; steps between them are kept."""
        count = min(count, len(self._past))
        if count <= 0:
            return
        undone = self._past[-count:]
        del self._past[-count:]
        moment = undone[0][0]
        (self._mean, self._spread), self._rested, self._still = moment.belief, moment.rested, moment.still
        self._origin = moment.origin
        if self._record is not None:
            self._record.rewind(moment.entries)
        for event in [event for _, events in undone for event in events]:
            if event is FilterRequest.MARK:
                self.mark()
            elif event is FilterRequest.ORIGIN:
                self.set_origin()
            else:
                self.advance(event)
        self.refused += count
        self._lost.doubt(count)

    def begin(self, found: FoundTrack) -> None:
        """Start again at a pose computed from fixes; only the estimate of the gyro's bias is kept."""
        known = [states.BIAS, states.WARM_UP]
        mean, spread = self._model.start(np.array(found.pose), 0.0)
        mean[known], spread[np.ix_(known, known)] = self._mean[known], self._spread[np.ix_(known, known)]
        spread[:3, :3] = found.covariance
        self._mean, self._spread = mean, spread
        self._forget_past()

    def begin_with(self, belief: Belief, supposed: FieldNoise) -> None:
        """Start again with a given state: mean (13,) and covariance (13, 13), estimated with the noise model
        `supposed`.

        Where this filter's own noise model has larger errors, the differences are added to the covariance. If
        its slowly changing error of the GNSS fixes is larger, the variance of the position grows as well.
        """
        mean, spread = belief.mean.copy(), belief.covariance.copy()
        mean[states.HEADING] = wrap(float(mean[states.HEADING]))
        here, there = (
            np.diag(self._model.start(mean[:3], 0.0)[1]),
            np.diag(FieldModel(supposed).start(mean[:3], 0.0)[1]),
        )
        more = np.maximum(here - there, 0.0)
        slips = [states.SCALE, states.TURN_SLIP, states.SLIP, states.SIDE]
        spread[slips, slips] += more[slips]
        for place, error in ((states.X, states.GPS_X), (states.Y, states.GPS_Y)):
            spread[place, place] += more[error]
            spread[error, error] += more[error]
            spread[place, error] -= more[error]
            spread[error, place] -= more[error]
        self._mean, self._spread = mean, spread
        self._still = np.zeros(2)
        self._forget_past()

    def _forget_past(self) -> None:
        """Forget earlier readings: only the belief that the filter starts with counts."""
        self._origin = None if self._origin is None else self._origin.unrelated()
        self._past.clear()
        self._monitor.reset()
        if self._record is not None:
            self._record.start()

    def _start_again(self, sigma: float) -> bool:
        """Start again from the pose on which the refused fixes agree; return whether they agree."""
        heading = math.sqrt(float(self._spread[states.HEADING, states.HEADING]))
        found = self._lost.found(math.hypot(sigma, self.noise.gps_drift), self.pose, heading)
        if found is None:
            return False
        self.begin(found)
        self.restarts += 1
        return True
