"""Refuse fixes that jump against what wheels and gyros say between them."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap

SIGMAS = 4.0  # of a fix against the mean of those before it
AVERAGED = 5  # fixes that are averaged
SEEN = 60  # steps between fixes by which the white error is estimated
ENOUGH = 20  # of them, before the estimate is used
SLIP = 0.04  # of the way since the latest good fix: what wheels and heading may be off
WANDER_M = 0.3  # per root second, that slow errors may change
PATIENCE_S = 20.0  # for which a jump may last before it is believed
RAYLEIGH = math.sqrt(2.0 * math.log(2.0))  # median of a length, in sigmas of an axis
Array = NDArray[np.float64]


class JumpGate:
    """Compares each fix with the latest good ones, carried on by odometry.

    Slow errors of the fixes cancel in such a difference, so it shows jumps that are small against them. All
    fixes take part, also those that a localizer isn't given because they come too often. Until the heading is
    known only the length of the way counts: no vehicle is faster than its wheels.
    """

    def __init__(self, sigma: float) -> None:
        """Suppose a white error of `sigma` [m] an axis until enough fixes have shown it."""
        self._sigma = sigma
        self._good = deque[tuple[float, Array, Pose2, float]](maxlen=AVERAGED)
        self._steps = deque[float](maxlen=SEEN)
        self._since: float | None = None  # [s] when the first fix of a jump came

    def refusal(
        self,
        time: float,
        position: Array,
        odometry: Pose2,
        way: float,
        heading: float | None,
        sigma: float,
        heading_sigma: float = 0.0,
    ) -> str:
        """Return why a fix isn't believed, in words; empty if it is.

        Args:
            time: in [s].
            position: (2,) in [m].
            odometry: pose by wheels and gyros alone.
            way: that the wheels have driven so far, in [m].
            heading: world's, in [rad]; None while it is open.
            sigma: what the receiver says, an axis, in [m]; NaN if nothing.
            heading_sigma: of the world's heading, in [rad]: it turns the way since the latest good fix aside.
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

    def _off(self, position: Array, odometry: Pose2, way: float, turn: float | None) -> float:
        """Return how far a fix is from where the good ones before it expect it, in [m]."""
        if turn is None:
            _, last, _, before = self._good[-1]
            return max(0.0, float(np.hypot(*(position - last))) - abs(way - before))
        expected = [last + _moved(odometry, then, turn) for _, last, then, _ in self._good]
        return float(np.hypot(*(position - np.mean(expected, axis=0))))

    def _limit(self, sigma: float, way: float, time: float, heading_sigma: float) -> float:
        if len(self._steps) >= ENOUGH:
            white = float(np.median(self._steps)) / RAYLEIGH / math.sqrt(2.0)
        else:
            white = sigma if math.isfinite(sigma) else self._sigma
        alone = math.sqrt(1.0 + 1.0 / len(self._good)) * white
        aside = heading_sigma * way
        return SIGMAS * math.hypot(alone, WANDER_M * math.sqrt(time), aside) + SLIP * abs(way)

    def _learn(self, position: Array, odometry: Pose2, turn: float) -> None:
        _, last, then, _ = self._good[-1]
        self._steps.append(float(np.hypot(*(position - last - _moved(odometry, then, turn)))))

    def _lasts(self, time: float) -> bool:
        """Return whether the fixes have been off for so long that they are right."""
        self._since = time if self._since is None else self._since
        return time - self._since > PATIENCE_S


def _moved(now: Pose2, then: Pose2, turn: float) -> Array:
    """Return the way (2,) between two poses of odometry, turned into the world."""
    x, y = now.x - then.x, now.y - then.y
    return np.array([math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y])
