"""Common interface of the outdoor localizers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.numerics.arrays import FloatArray

CONSISTENCY_WINDOW = 60.0  # [s] over which readings are held against what was expected of them
MIN_READINGS = 10  # readings to judge by
MAX_MEAN_SIGMAS = 4.0  # standard deviations of a mean of squares, that of one is 1 where errors are normal
MAX_REFUSED_SHARE = 0.5  # share of readings: more, and it is the filter that may be wrong
STEP_PERIOD_S = 0.1  # [s] of a filter's step; gyros and wheels are integrated with each reading


class Inconsistency(NamedTuple):
    """Evidence that a filter's errors are larger than its covariance says: a statistic of the latest readings
    that exceeds its limit.
    """

    what: str
    """Statistic of the readings that is inconsistent."""
    value: float
    limit: float


class FieldLocalizer(ABC):
    """Base class of estimators of world_T_base from wheels, gyros, accelerometers and GNSS; x is east, y
    north.

    Between two steps of the filter, its pose is updated by gyro odometry, so that there is a new pose each
    period.
    """

    STATE: ClassVar[Mapping[str, Any]] = {"_since": Pose2, "_lead": Pose2 | None}
    """Attributes that change, besides the odometry's, with their types."""
    REST_PERIOD: ClassVar[float] = STEP_PERIOD_S
    """Duration of a filter step at rest, in [s]."""
    TAKES_FIXES: ClassVar[bool] = True
    """True if it uses GNSS fixes."""
    TAKES_RANGES: ClassVar[bool] = False
    """True if it uses ranges to beacons."""

    def __init__(self, start: Pose2, euler: bool = True) -> None:
        """Start at a pose.

        Args:
            start: world_T_base.
            euler: False to take body rates for rates of roll, pitch and yaw, as the paper has them.
        """
        self.refusal = ""
        """Why the latest fix wasn't believed, in words; empty if it was."""
        self.log_likelihood = math.nan
        """Log-likelihood of all fixes; NaN if not computed."""
        self._odometry = GyroOdometry(start, euler)
        self._since = start  # dead-reckoned pose at the filter's last step
        self._lead: Pose2 | None = None  # of the origin before the filter's step there; None without one

    @property
    def odometry(self) -> GyroOdometry:
        """Odometry by wheels and gyros alone."""
        return self._odometry

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base, in [rad]."""
        return self._odometry.tilt

    @property
    def heading_known(self) -> bool:
        """True if the base's heading in the field's frame is known, so that `pose` is valid in this frame."""
        return True

    @property
    def meanwhile(self) -> Belief | None:
        """Pose estimated from fixes while the heading is still unknown; None once the heading is known.

        The result has a mean (3,) and a covariance (3, 3) of x, y in the field's frame in [m] and heading in
        [rad]. Until the heading is known, `pose` follows wheels and gyros only, so that the base can return
        to its start.
        """
        return None

    @property
    def inconsistency(self) -> Inconsistency | None:
        """Evidence that the last minute's fixes contradict the filter's covariance; None if they agree."""
        return None

    @property
    def parts(self) -> Sequence[Any]:
        """Components of the localizer whose attributes a checkpoint saves too; their `STATE` names these
        attributes.
        """
        return ()

    @property
    def pose(self) -> Pose2:
        """Current estimate of world_T_base."""
        return self._estimate().compose(self._odometry.pose.relative_to(self._since))

    @property
    @abstractmethod
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of x, y in [m] and heading in [rad], in the field's frame, at the last step."""

    @property
    def particles(self) -> FloatArray | None:
        """Particles (3, n): x, y in [m], heading in [rad], in the field's frame; None for a filter without
        particles.
        """
        return None

    def set_origin(self) -> None:
        """Set the present pose as the origin from which `displacement` is measured."""
        self._lead = self._odometry.pose.relative_to(self._since)
        self._set_origin()

    @property
    def displacement(self) -> Belief:
        """Motion of the base since `set_origin` was called, as the pose origin_T_base with its covariance.

        The mean (3,) is x ahead and y left in [m] and the turn in [rad]. Over some metres the motion is known
        far better than the pose on the Earth, because errors common to the poses at its start and end cancel,
        and the heading on the Earth does not matter.

        Raises:
            ValueError: no origin was set.
        """
        if self._lead is None:
            raise ValueError("no origin was set")
        mean, covariance = self._relative_pose()
        now = Pose2(*mean.tolist()).compose(self._odometry.pose.relative_to(self._since))
        x, y, turn = now.relative_to(self._lead)
        return Belief(np.array([x, y, wrap(turn)]), covariance)

    def predict(self, rates: FloatArray, accelerations: FloatArray, wheels: FloatArray, dt: float) -> None:
        """Move the pose by one period's readings; a reading that isn't finite is replaced by the reading
        before.

        Args:
            rates: (3,) angular velocities in the base's axes, in [rad/s].
            accelerations: (3,) specific force in the base's axes, gravity included (z up at rest), in [m/s²].
            wheels: (2,) travel of the left and right wheel in the period, in [m].
            dt: length of the period, in [s].
        """
        self._odometry.update(rates, accelerations, wheels, dt)
        due = self.REST_PERIOD if self._odometry.at_rest else STEP_PERIOD_S
        if self._odometry.pending >= due - 1e-9:
            self._flush()

    def fix(self, position: FloatArray, sigma: float | None = None) -> bool:
        """Correct the pose by a GNSS position that was measured now; return whether the position was used.

        A position is not used if it is not finite, if it contradicts the filter's estimate and earlier
        positions, or if `sigma` is not finite or not above zero.

        Args:
            position: (2,) position of the antenna in the field's frame, in [m].
            sigma: standard deviation along each axis, as reported by the receiver, in [m]; None: that of the
                noise model.
        """
        if not np.all(np.isfinite(position)) or (sigma is not None and not 0.0 < sigma < math.inf):
            return False
        self._flush()
        return self._fix(np.asarray(position, dtype=np.float64), sigma)

    def ranges(self, distances: FloatArray) -> None:
        """Correct the pose by ranges (k,) to radio beacons, in [m], measured now; NaN for beacons without a
        reading.
        """
        if self.TAKES_RANGES:
            self._flush()
            self._ranges(distances)

    def mark(self) -> Belief | None:
        """Mark the present time as one whose state `smoothed` returns later, and return the present estimate.

        None for a filter without smoother, which marks nothing.
        """
        return None

    def smoothed(self) -> list[Belief]:
        """Return the states at the times that `mark` marked, with x, y and heading first; empty without a
        smoother.

        Each estimate uses all readings so far, also those after the marked time.
        """
        return []

    def forget_derived(self) -> None:
        """Discard cached values that were computed from the state, because the state was replaced by a stored
        one.
        """

    def _flush(self) -> None:
        if self._odometry.pending > 0.0:
            self._advance(self._odometry.take())
            self._since = self._odometry.pose

    def _ranges(self, distances: FloatArray) -> None:
        """Update with ranges, after all earlier readings."""

    @abstractmethod
    def _set_origin(self) -> None:
        """Measure `_relative_pose` from the filter's last step on."""

    @abstractmethod
    def _relative_pose(self) -> Belief:
        """Return origin_T_base of the filter's last step: x, y in [m] and heading in [rad].

        Mean (3,) and covariance (3, 3).
        """

    @abstractmethod
    def _estimate(self) -> Pose2:
        """Return the filter's pose at its last step."""

    @abstractmethod
    def _advance(self, advance: Advance) -> None:
        """Take one step of the filter, by the motion since the last one."""

    @abstractmethod
    def _fix(self, position: FloatArray, sigma: float | None) -> bool:
        """Update with a fix of finite position, after all earlier readings."""


def inconsistency_of(squares: Sequence[tuple[float, float | None]], axes: int = 2) -> Inconsistency | None:
    """Return the statistic by which the latest readings contradict a filter's covariance; None if they agree.

    Args:
        squares: for each reading its time in [s], and its squared Mahalanobis distance from the expected
            value; None instead of the distance if it was rejected.
        axes: number of axes of each reading.
    """
    if len(squares) < MIN_READINGS:
        return None
    believed = [square for _, square in squares if square is not None]
    refused = 1.0 - len(believed) / len(squares)
    if refused > MAX_REFUSED_SHARE:
        return Inconsistency("share of them that can't be believed", refused, MAX_REFUSED_SHARE)
    mean, spread = sum(believed) / len(believed) / axes, math.sqrt(2.0 / axes / len(believed))
    limit = 1.0 + MAX_MEAN_SIGMAS * spread
    return Inconsistency("mean square of their errors, in sigmas", mean, limit) if mean > limit else None
