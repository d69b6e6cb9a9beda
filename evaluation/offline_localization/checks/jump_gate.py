"""Rejection of fixes that jump relative to wheels and gyros."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray

MAX_FIX_SIGMAS = 4.0  # between a fix and the mean of the fixes before it
AVERAGED_FIXES = 5
MAX_STEPS = 60  # between fixes, from which the white error is estimated
MIN_STEPS = 20  # before the estimate is used
SLIP_RATIO = 0.04  # error of wheels and heading, relative to the distance since the latest good fix
WANDER_M = 0.3  # change of slow errors, per root second
PATIENCE_S = 20.0  # after which a lasting jump is accepted
RAYLEIGH_MEDIAN = math.sqrt(2.0 * math.log(2.0))  # median of a 2D length, in sigmas per axis


class JumpGate:
    """Filter that rejects fixes of a satellite receiver that jump.

    Each fix is compared with the latest good fixes, moved on by odometry. Slow errors of the fixes cancel in
    the difference, so that jumps smaller than these errors are detected. All fixes take part, including those
    that are too frequent for the localizer. While the heading is unknown, only the length of the motion is
    compared: no vehicle is faster than its wheels.
    """

    def __init__(self, sigma: float) -> None:
        """Assume a white error of `sigma` [m] per axis until it can be estimated from enough fixes."""
        self._sigma = sigma
        self._good = deque[tuple[float, FloatArray, Pose2, float]](maxlen=AVERAGED_FIXES)
        self._steps = deque[float](maxlen=MAX_STEPS)
        self._since: float | None = None  # [s] when the first fix of a jump came

    def refusal(
        self,
        time: float,
        position: FloatArray,
        odometry: Pose2,
        way: float,
        heading: float | None,
        sigma: float,
        heading_sigma: float = 0.0,
    ) -> str:
        """Return the reason why a fix is rejected; empty if it is accepted.

        Args:
            time: time of the fix, in [s].
            position: (2,) in the world, in [m].
            odometry: pose by wheels and gyros alone, in a frame of its own.
            way: distance driven by the wheels so far, in [m].
            heading: heading in the world, in [rad]; None while it is unknown.
            sigma: standard deviation per axis that the receiver states, in [m]; NaN if it states none.
            heading_sigma: standard deviation of the heading, in [rad], which adds a sideways error to the
                motion since the latest good fix.
        """
        turn = None if heading is None else wrap(heading - odometry.theta)
        if not self._good:
            self._good.append((time, position, odometry, way))
            return ""
        latest, _, _, before = self._good[-1]
        off = self._off(position, odometry, way, turn)
        limit = self._limit(sigma, way - before, time - latest, 0.0 if turn is None else heading_sigma)
        if off > limit and not self._lasts(time):
            return f"jumps {off:.1f} m against wheels and gyros, {limit:.1f} m allowed"
        if off > limit:
            self._good.clear()
        elif turn is not None:
            self._learn(position, odometry, turn)
        self._since = None
        self._good.append((time, position, odometry, way))
        return ""

    def _off(self, position: FloatArray, odometry: Pose2, way: float, turn: float | None) -> float:
        """Return the distance in [m] between a fix and its prediction from the good fixes before it.

        Args:
            position: (2,) fix in the world, in [m].
            odometry: pose by wheels and gyros alone.
            way: distance driven by the wheels so far, in [m].
            turn: turn from the odometry's frame to the world, in [rad]; None while the heading is unknown.
        """
        if turn is None:
            _, last, _, before = self._good[-1]
            return max(0.0, float(np.hypot(*(position - last))) - abs(way - before))
        expected = [last + _moved(odometry, then, turn) for _, last, then, _ in self._good]
        return float(np.hypot(*(position - np.mean(expected, axis=0))))

    def _limit(self, sigma: float, way: float, time: float, heading_sigma: float) -> float:
        if len(self._steps) >= MIN_STEPS:
            white = float(np.median(self._steps)) / RAYLEIGH_MEDIAN / math.sqrt(2.0)
        else:
            white = sigma if math.isfinite(sigma) else self._sigma
        alone = math.sqrt(1.0 + 1.0 / len(self._good)) * white
        aside = heading_sigma * way
        return MAX_FIX_SIGMAS * math.hypot(alone, WANDER_M * math.sqrt(time), aside) + SLIP_RATIO * abs(way)

    def _learn(self, position: FloatArray, odometry: Pose2, turn: float) -> None:
        _, last, then, _ = self._good[-1]
        self._steps.append(float(np.hypot(*(position - last - _moved(odometry, then, turn)))))

    def _lasts(self, time: float) -> bool:
        """Return whether the fixes have differed for so long that they must be right."""
        self._since = time if self._since is None else self._since
        return time - self._since > PATIENCE_S


def _moved(now: Pose2, then: Pose2, turn: float) -> FloatArray:
    """Return the motion (2,) in [m] between two poses of odometry, rotated into the world."""
    x, y = now.x - then.x, now.y - then.y
    return np.array([math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y])
