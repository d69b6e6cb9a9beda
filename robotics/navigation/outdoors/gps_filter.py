"""A Kalman filter of wheels, gyros and GPS that knows what it doesn't know."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.fix_monitor import LONGEST, FixMonitor
from handcart.robotics.navigation.localization.lost_track import LostTrack
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.field_model import FieldModel, carried, corrected
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE, FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.navigation.outdoors.smoothing import Belief, Entries, TrackRecord

BIAS_PERIOD = 1.0  # [s] at rest over which the gyro is averaged into one reading
Array = NDArray[np.float64]


class _Moment(NamedTuple):
    """All that changes in the filter, before a fix."""

    belief: Belief
    rested: bool
    still: Array
    entries: Entries


class GpsFilter(FieldLocalizer):
    """An extended Kalman filter with the errors themselves as states (see `FieldModel`).

    A fix that its own covariance can't explain is refused; so are fixes that are off together, and those of
    them that were believed before it showed are taken back (see `FixMonitor`). Refused fixes that agree with
    each other and with the odometry say that the filter is wrong, not they (see `LostTrack`): it then starts
    again from them. A reading that isn't finite is not looked at.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        **FieldLocalizer.STATE,
        "_mean": Array,
        "_spread": Array,
        "_rested": bool,
        "_still": Array,
        "_lost": LostTrack,
        "_monitor": FixMonitor,
        "_past": list[tuple[_Moment, list[Advance | None]]],
        "_record": TrackRecord | None,
        "refused": int,
        "restarts": int,
    }

    def __init__(
        self,
        start: Pose2,
        noise: FieldNoise = REFERENCE,
        start_position: float = 0.05,
        record: TrackRecord | None = None,
    ) -> None:
        """Start at a pose whose position is right to `start_position` [m] an axis.

        Args:
            start: world_T_base.
            noise: what to believe of wheels, gyros and GPS.
            start_position: sigma in [m].
            record: takes down what a smoother needs.
        """
        super().__init__(start)
        self._noise = noise
        self._model = FieldModel(noise)
        self._mean, self._spread = self._model.start(np.array(start), start_position)
        self._rested = True
        self._still = np.zeros(2)  # turn and time since the bias was seen, at rest
        self._lost = LostTrack()
        self._monitor = FixMonitor()
        self._past: list[tuple[_Moment, list[Advance | None]]] = []  # before each believed fix, and what came
        self._record = record
        self.refused = 0
        """Fixes that were not believed."""
        self.restarts = 0
        """How often the fixes were believed against the filter."""
        if record is not None:
            record.start()

    @property
    def covariance(self) -> Array:
        """See `FieldLocalizer`."""
        return self._spread[:3, :3].copy()

    @property
    def mean(self) -> Array:
        """(12,) all states."""
        return self._mean.copy()

    def mark(self) -> Belief:
        """This moment is wanted from the smoother; what the filter holds now."""
        self._flush()
        self._note(None)
        now = Belief(self._mean.copy(), self._spread.copy())
        if self._record is not None:
            self._record.mark(now)
        return now

    def smoothed(self) -> list[Belief]:
        """The marked moments by all that was seen so far; none without a record."""
        return [] if self._record is None else self._record.smoothed()

    def _estimate(self) -> Pose2:
        x, y, heading = self._mean[:3].tolist()
        return Pose2(x, y, wrap(heading))

    def _advance(self, advance: Advance) -> None:
        self._note(advance)
        if advance.rest < advance.time:
            self._see_bias()
        new_leg = self._rested and advance.rest < advance.time
        self._mean, transition, added = self._model.step(self._mean, advance, new_leg)
        self._spread = carried(self._spread, transition, added)
        self._rested = advance.rest > 0.0
        self._still = self._still + np.array([advance.still, advance.rest])
        if self._record is not None:
            self._record.step(transition)
        if self._still[1] >= BIAS_PERIOD:
            self._see_bias()

    def _see_bias(self) -> None:
        """At rest the vertical gyro reads nothing but its bias."""
        turned, time = self._still
        if time <= 0.0:
            return
        row = np.zeros((1, states.SIZE))
        row[0, [states.BIAS, states.WARM_UP]] = 1.0
        residual = turned / time - self._mean[states.BIAS] - self._mean[states.WARM_UP]
        self._correct(row, np.array([residual]), self._noise.gyro_white**2 / time)
        self._still = np.zeros(2)

    def _fix(self, position: Array, sigma: float | None) -> bool:
        variance = (self._noise.gps_white if sigma is None else sigma) ** 2
        rows, residual, lever = self._forecast(position)
        forecast = rows @ self._spread @ rows.T
        if self._monitor.doubting:
            believed = self._monitor.cleared(residual, forecast, variance)
        else:
            suspects = self._monitor.suspects(residual, forecast + variance * np.eye(2))
            believed = suspects == 0
            self._take_back(suspects - 1)
        self._lost.take(self._odometry.pose, position - lever, believed)
        if believed:
            self._past.append((self._moment(), []))
            del self._past[:-LONGEST]
            self._correct(rows, residual, variance)
            return True
        self.refused += 1
        return self._start_again(math.sqrt(variance))

    def _forecast(self, position: Array) -> tuple[Array, Array, Array]:
        """How a fix depends on the states (2, 12), its residual (2,), the antenna beside the base (2,)."""
        lever = self._lever()
        rows = np.zeros((2, states.SIZE))
        rows[[0, 1], [states.X, states.Y]] = rows[[0, 1], [states.GPS_X, states.GPS_Y]] = 1.0
        rows[:, states.HEADING] = -lever[1], lever[0]
        return rows, position - rows[:, [0, 1, 10, 11]] @ self._mean[[0, 1, 10, 11]] - lever, lever

    def _lever(self) -> Array:
        """(2,) from the base to the antenna in the world's axes, in [m]."""
        x, y, z = self._noise.antenna
        (roll, pitch), heading = self.tilt, float(self._mean[states.HEADING])
        across, up = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
        along = x * math.cos(pitch) + up * math.sin(pitch)
        cos, sin = math.cos(heading), math.sin(heading)
        return np.array([cos * along - sin * across, sin * along + cos * across])

    def _correct(self, rows: Array, residual: Array, variance: float) -> None:
        if self._record is not None:
            self._record.correct(self._spread, rows, residual, variance)
        self._mean, self._spread = corrected(self._mean, self._spread, rows, residual, variance)

    def _moment(self) -> _Moment:
        entries = Entries(0, 0, None) if self._record is None else self._record.entries
        return _Moment(Belief(self._mean, self._spread), self._rested, self._still, entries)

    def _note(self, event: Advance | None) -> None:
        """Keep a step, or a mark (None), in case the fixes before it are taken back."""
        if self._past:
            self._past[-1][1].append(event)

    def _take_back(self, count: int) -> None:
        """Undo the latest `count` believed fixes; what came between them stays."""
        count = min(count, len(self._past))
        if count <= 0:
            return
        undone = self._past[-count:]
        del self._past[-count:]
        moment = undone[0][0]
        (self._mean, self._spread), self._rested, self._still = moment.belief, moment.rested, moment.still
        if self._record is not None:
            self._record.rewind(moment.entries)
        for event in [event for _, events in undone for event in events]:
            if event is None:
                self.mark()
            else:
                self._advance(event)
        self.refused += count
        self._lost.doubt(count)

    def _start_again(self, sigma: float) -> bool:
        """Take the refused fixes' word for the pose, if they have one."""
        heading = math.sqrt(float(self._spread[states.HEADING, states.HEADING]))
        found = self._lost.found(math.hypot(sigma, self._noise.gps_drift), self._estimate(), heading)
        if found is None:
            return False
        known = [states.BIAS, states.WARM_UP]
        mean, spread = self._model.start(np.array(found.pose), 0.0)
        mean[known], spread[np.ix_(known, known)] = self._mean[known], self._spread[np.ix_(known, known)]
        spread[:3, :3] = found.covariance
        self._mean, self._spread = mean, spread
        self.restarts += 1
        self._past.clear()
        self._monitor.reset()
        if self._record is not None:
            self._record.start()
        return True
