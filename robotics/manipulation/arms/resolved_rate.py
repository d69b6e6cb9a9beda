"""Leading a planar arm's tip along a straight line by joint rates."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.arms.scara import Scara
from handcart.robotics.numerics.arrays import FloatArray

CHECK_STEP_M = 0.005  # [m] between postures that are looked at before a line is driven


class RateLimits(NamedTuple):
    """Limits of the tip's speed and acceleration and of the joints' rates, for moving the tip along a
    straight line.
    """

    speed: float = 0.2
    """Maximum speed of the tip, in [m/s]."""
    acceleration: float = 0.4
    """Maximum acceleration of the tip, in [m/s²]."""
    rate: float = 1.5
    """Maximum rate of each joint, in [rad/s]."""


class ResolvedRate:
    """Controller that moves the tip of a SCARA arm along a straight line, by resolved rates (Whitney, 1969).

    Joint rates are computed from the tip's wanted velocity by the inverse of the Jacobian.

    The Jacobian is taken at the middle of each period. The tip accelerates and brakes along the line; its
    distance from the line is driven to zero. If a joint reaches its maximum rate, the tip becomes slower but
    stays on the line.
    """

    def __init__(
        self,
        arm: Scara,
        start: FloatArray,
        end: FloatArray,
        limits: RateLimits = RateLimits(),
        jacobian: Callable[[FloatArray], FloatArray] | None = None,
    ) -> None:
        """Lead from `start` to `end`, (2,) each in [m], in the arm's plane, from the first joint.

        Another `jacobian` than that of the arm is for tests.
        """
        self._arm, self._start, self._end, self._limits = arm, np.asarray(start), np.asarray(end), limits
        self._length = float(np.hypot(*(self._end - self._start)))
        self._along = (self._end - self._start) / max(self._length, 1e-12)
        self._jacobian = arm.jacobian if jacobian is None else jacobian
        self._speed = 0.0

    def left(self, q: FloatArray) -> float:
        """Distance of the tip from the end of the commanded line, in [m], with the joints at `q` (2,) in
        [rad].
        """
        return float(np.hypot(*(self._end - self._arm.tip(q))))

    def astray(self, q: FloatArray) -> float:
        """Return the distance in [m] of the tip from the commanded line with joints at `q` (2,) in [rad]."""
        return float(np.hypot(*self._aside(self._arm.tip(q))))

    def command(self, q: FloatArray, dt: float) -> FloatArray:
        """Return the joint rates (2,), in [rad/s], that move the tip along the line in the next `dt` [s].

        Args:
            q: (2,) present joints, in [rad].
            dt: duration, in [s].
        """
        tip = self._arm.tip(q)
        ahead = float((self._end - tip) @ self._along)
        braking = math.sqrt(2.0 * 0.8 * self._limits.acceleration * abs(ahead))
        most = min(self._limits.speed, self._speed + self._limits.acceleration * dt, braking, abs(ahead) / dt)
        velocity = math.copysign(most, ahead) * self._along - self._aside(tip) / (2.0 * dt)
        rates = np.linalg.solve(self._jacobian(q), velocity)
        rates = np.linalg.solve(self._jacobian(q + 0.5 * dt * rates), velocity)
        share = min(1.0, self._limits.rate / max(1e-12, float(np.abs(rates).max())))
        self._speed = share * most
        out: FloatArray = np.asarray(share * rates, dtype=np.float64)
        return out

    def _aside(self, tip: FloatArray) -> FloatArray:
        away = tip - self._start
        return np.asarray(away - (away @ self._along) * self._along)


def line_postures(arm: Scara, q: FloatArray, target: FloatArray) -> FloatArray | None:
    """Return postures (n, 2), in [rad], along a straight line of the tip; None if one exceeds a joint limit.

    The first posture is the start, the last one is at the target, and the tip moves at most `CHECK_STEP_M`
    from one to the next.

    Args:
        arm: the arm.
        q: joints at the start, (2,) angles in [rad], or (3,) with the slide in [m].
        target: (2,) end of the line in the arm's plane, in [m].
    """
    start = arm.tip(q)
    count = max(1, math.ceil(float(np.hypot(*(target - start))) / CHECK_STEP_M))
    free = arm._replace(theta1_working=arm.theta1)
    found = [free.inverse(start + share * (target - start)) for share in np.linspace(0.0, 1.0, count + 1)[1:]]
    postures = [posture for posture in found if posture is not None]
    return np.array([q[:2], *postures]) if len(postures) == count else None


def way_to(arm: Scara, q: FloatArray, target: FloatArray) -> list[FloatArray] | None:
    """Return waypoints (2,) of the tip to a target, in the arm's plane, in [m], joined by straight lines.

    The target is the only waypoint if the straight line to it keeps the joint limits. Otherwise the waypoints
    are on the path of a motion at constant joint rates, which swings around the shoulder. None if the target
    is out of reach.

    Args:
        arm: the arm.
        q: joints at the start, (2,) angles in [rad], or (3,) with the slide in [m].
        target: (2,) position in the arm's plane, in [m].
    """
    goal = arm.inverse(target)
    if goal is None:
        return None
    if line_postures(arm, q, target) is not None:
        return [np.asarray(target, dtype=np.float64)]
    count = max(2, math.ceil(float(np.abs(goal - q[:2]).max()) / 0.1))
    between = [arm.tip(q[:2] + share * (goal - q[:2])) for share in np.linspace(0.0, 1.0, count + 1)[1:-1]]
    return [*between, np.asarray(target, dtype=np.float64)]
