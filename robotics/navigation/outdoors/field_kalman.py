"""A Kalman filter of wheels, gyros and GPS that supposes certain errors of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.fix_monitor import LONGEST, FixMonitor, whitened
from handcart.robotics.navigation.localization.lost_track import FoundTrack, LostTrack
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_model import FieldModel, carried, corrected, field_step
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE, FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.navigation.outdoors.smoothing import Belief, Entries, TrackRecord

SEEN = [states.X, states.Y, states.GPS_X, states.GPS_Y, states.DELAY]  # by a fix, besides the heading
ODD = math.log(0.001)  # logarithm of the share of fixes that begin to lie anywhere
ODD_STILL = math.log(0.95)  # and of those that go on to lie where the one before was
REFLECTION = 10.0  # [m] an axis, how far off they are
ANEW = -20.0  # logarithm of how likely it is that a filter that is right has to start again
BIAS_PERIOD = 1.0  # [s] at rest over which the gyro is averaged into one reading
Array = NDArray[np.float64]


class _Moment(NamedTuple):
    """All that changes in the filter, before a fix."""

    belief: Belief
    rested: bool
    still: Array
    entries: Entries


class Fixed(NamedTuple):
    """What came of a fix."""

    believed: bool
    log_likelihood: float
    """Of the fix, before it was taken in, by what the filter supposes."""
    square: float
    """Squared distance to where the fix was expected, in sigmas: 2 on average."""
    why: str = ""
    """It wasn't believed, in words."""


class FieldKalman:
    """An extended Kalman filter with the errors themselves as states (see `FieldModel`).

    A fix that its own covariance can't explain is refused; so are fixes that are off together, and those of
    them that were believed before it showed are taken back (see `FixMonitor`). Refused fixes that agree with
    each other and with the odometry say that the filter is wrong, not they (see `LostTrack`): it then starts
    again from them. A reading that isn't finite is not looked at.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        "_mean": Array,
        "_spread": Array,
        "_rested": bool,
        "_still": Array,
        "_speed": float,
        "_lost": LostTrack,
        "_monitor": FixMonitor,
        "_past": list[tuple[_Moment, list[Advance | None]]],
        "_refused": Array,
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
        self._noise = noise
        self._model = FieldModel(noise)
        self._figures = self._model.figures
        self._mean, self._spread = self._model.start(np.array(start), start_position)
        self._rested = True
        self._still = np.zeros(2)  # turn and time since the bias was seen, at rest
        self._speed = 0.0
        self._lost = LostTrack()
        self._monitor = FixMonitor()
        self._past: list[tuple[_Moment, list[Advance | None]]] = []  # before each believed fix, and what came
        self._refused = np.zeros(0)  # residual of the fix before, if it wasn't believed
        self._record = record
        self.refused = 0
        """Fixes that were not believed."""
        self.restarts = 0
        """How often the fixes were believed against the filter."""
        if record is not None:
            record.start()

    @property
    def belief(self) -> Belief:
        """Mean (13,) and covariance (13, 13) of all states."""
        return Belief(self._mean, self._spread)

    def mark(self) -> Belief:
        """This moment is wanted from the smoother; what the filter holds now."""
        self._note(None)
        now = Belief(self._mean.copy(), self._spread.copy())
        if self._record is not None:
            self._record.mark(now)
        return now

    def smoothed(self) -> list[Belief]:
        """The marked moments by all that was seen so far; none without a record."""
        return [] if self._record is None else self._record.smoothed()

    @property
    def pose(self) -> Pose2:
        """world_T_base."""
        x, y, heading = self._mean[:3].tolist()
        return Pose2(x, y, wrap(heading))

    def advance(self, advance: Advance) -> None:
        """One step: what wheels and gyros said."""
        self._note(advance)
        if advance.rest < advance.time:
            self._see_bias()
        new_leg = self._rested and advance.rest < advance.time
        self._mean, transition, added = field_step(self._mean, np.array(advance), new_leg, self._figures)
        self._spread = carried(self._spread, transition, added)
        self._rested = advance.rest > 0.0
        self._speed = advance.forward / advance.time
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

    def fix(self, position: Array, sigma: float | None, odometry: GyroOdometry) -> Fixed:
        """Take in a GPS position (2,) in [m], if it can be believed.

        `sigma` [m] an axis is what the receiver says, None: what the filter supposes; `odometry` is what
        wheels and gyros alone say.
        """
        variance = (self._noise.gps_white if sigma is None else sigma) ** 2
        rows, residual, lever = self._forecast(position, odometry.tilt)
        forecast = rows @ self._spread @ rows.T
        whole = forecast + variance * np.eye(2)
        white = whitened(residual, whole)
        square = float(white @ white)
        why = "fixes before it were off together: it waits until some in a row are where it expects them"
        if self._monitor.doubting:
            believed = self._monitor.cleared(residual, forecast, variance)
        else:
            suspects = self._monitor.suspects(residual, whole)
            believed = suspects == 0
            off = f"{float(np.hypot(*residual)):.2f} m off, {math.sqrt(square):.1f} sigma"
            why = off if suspects == 1 else f"the last {suspects} are off together, this one by {off}"
            self._take_back(suspects - 1)
        self._lost.take(odometry.pose, position - lever, believed)
        if believed:
            self._past.append((self._moment(), []))
            del self._past[:-LONGEST]
            self._correct(rows, residual, variance)
            self._refused = np.zeros(0)
            return Fixed(True, log_normal(residual, whole), square)
        likelihood = self._reflected(residual, whole)
        self.refused += 1
        if self._start_again(math.sqrt(variance)):
            return Fixed(True, likelihood + ANEW, square, "the filter starts again from these fixes")
        return Fixed(False, likelihood, square, why)

    def _reflected(self, residual: Array, whole: Array) -> float:
        """How likely a refused fix is: far off, or off as the one before it was."""
        anywhere = log_normal(residual, whole + REFLECTION**2 * np.eye(2)) + ODD
        if len(self._refused):
            again = log_normal(residual - self._refused, 2.0 * whole) + ODD_STILL
            anywhere = float(np.logaddexp(anywhere, again))
        self._refused = residual
        return anywhere

    def _forecast(self, position: Array, tilt: tuple[float, float]) -> tuple[Array, Array, Array]:
        """How a fix depends on the states (2, 13), its residual (2,), the antenna beside the base (2,)."""
        lever = level_lever(self._noise.antenna, tilt, float(self._mean[states.HEADING]))
        rows = np.zeros((2, states.SIZE))
        rows[[0, 1], [states.X, states.Y]] = rows[[0, 1], [states.GPS_X, states.GPS_Y]] = 1.0
        rows[:, states.HEADING] = -lever[1], lever[0]
        heading = float(self._mean[states.HEADING])
        rows[:, states.DELAY] = -self._speed * math.cos(heading), -self._speed * math.sin(heading)
        return rows, position - rows[:, SEEN] @ self._mean[SEEN] - lever, lever

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
                self.advance(event)
        self.refused += count
        self._lost.doubt(count)

    def begin(self, found: FoundTrack) -> None:
        """Start at a pose that was found; only what is known of the gyro is kept."""
        known = [states.BIAS, states.WARM_UP]
        mean, spread = self._model.start(np.array(found.pose), 0.0)
        mean[known], spread[np.ix_(known, known)] = self._mean[known], self._spread[np.ix_(known, known)]
        spread[:3, :3] = found.covariance
        self._mean, self._spread = mean, spread
        self._past.clear()
        self._monitor.reset()
        if self._record is not None:
            self._record.start()

    def _start_again(self, sigma: float) -> bool:
        """Take the refused fixes' word for the pose, if they have one."""
        heading = math.sqrt(float(self._spread[states.HEADING, states.HEADING]))
        found = self._lost.found(math.hypot(sigma, self._noise.gps_drift), self.pose, heading)
        if found is None:
            return False
        self.begin(found)
        self.restarts += 1
        return True


def log_normal(residual: Array, covariance: Array) -> float:
    """Logarithm of the density of `residual` (2,) that has no mean and a covariance (2, 2)."""
    white = whitened(residual, covariance)
    size = covariance[0, 0] * covariance[1, 1] - covariance[0, 1] * covariance[1, 0]
    return -0.5 * float(math.log(4.0 * math.pi**2 * size) + white @ white)


def level_lever(antenna: tuple[float, float, float], tilt: tuple[float, float], heading: float) -> Array:
    """(2,) from the base to its `antenna` [m] in the world's axes, in [m]; tilt and heading in [rad]."""
    x, y, z = antenna
    roll, pitch = tilt
    across, up = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
    along = x * math.cos(pitch) + up * math.sin(pitch)
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([cos * along - sin * across, sin * along + cos * across])
