"""Measure that a placement is scored with, and its limits."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

UNUSABLE_SCORE = -1.0


class Measure(IntEnum):
    """Kind of the score that a base pose gets at a point of the tool's path, for example reachability or
    manipulability.
    """

    REACHABILITY = 0
    """1 wherever the arm reaches: figure 2a of Shin (2005)."""
    MANIPULABILITY = 1
    """Yoshikawa's, eq. 2, whatever the direction of the path: figure 2b."""
    DIRECTIONAL = 2
    """Directional manipulability, eq. 6, with absolute values and own limits of joints (figures 2c, 4)."""
    SURE = 3
    """The lesser of eq. 6 and 1 - (wanted tool speed) / (exact top speed along the path), at each joint."""


class ScoreRule(NamedTuple):
    """Rule for the score of a base pose at a point, by a measure and limits on the lever of the tool's force.

    The lever about each joint, in [m], has to be long enough for the tool's speed and short enough for the
    joint's torque: b_min and b_max of Shin (2005).
    """

    measure: Measure
    low: FloatArray
    """(n,): tool speed over joint speed limit, in [m]; b_min of Shin (2005)."""
    high: FloatArray
    """(n,): joint torque limit over tool force, in [m]; b_max."""

    @classmethod
    def of_limits(
        cls, measure: Measure, velocity: FloatArray, torque: FloatArray, speed: float, force: float
    ) -> ScoreRule:
        """Return the rule that scores base poses by the limits of an arm's joints and by speed and force of
        its tool.

        Args:
            measure: measure of the score.
            velocity: (n,) speed limits in [rad/s].
            torque: (n,) torque limits in [Nm].
            speed: speed of the tool, in [m/s].
            force: force of the tool along the path, in [N].

        Raises:
            ValueError: a limit, the speed or the force isn't above zero, or a joint cannot have this speed
                and this force with the same lever (distance of the tool's force from the joint's axis).
        """
        if not (min(*np.atleast_1d(velocity), *np.atleast_1d(torque), speed, force) > 0.0):
            raise ValueError("speed and torque limits, speed and force must be above zero")
        low, high = speed / np.asarray(velocity, float), np.asarray(torque, float) / force
        if not (low < high).all():
            joint = int(np.argmin(low < high))
            raise ValueError(
                f"joint {joint} has no lever between {low[joint]:.3g} m (fast enough) and "
                f"{high[joint]:.3g} m (strong enough); allowed: a lower speed or force"
            )
        return cls(measure, low, high)

    @classmethod
    def uniform(cls, measure: Measure, low: float, high: float, joints: int) -> ScoreRule:
        """Return the rule for scoring base poses with the same limits in [m] on the force's lever at each
        joint.
        """
        return cls(measure, np.full(joints, low), np.full(joints, high))

    @property
    def limits(self) -> FloatArray:
        """Limits (3, n) on the lever arm of the tool's force about each of n joints, as an array for compiled
        functions.

        Rows are the low and high limits in [m], and 2 / (high - low) in [1/m].
        """
        return np.array((self.low, self.high, 2.0 / (self.high - self.low)))


@compiled
def worth(measure: int, elements: FloatArray, rates: FloatArray, spread: float, limits: FloatArray) -> float:
    """Return the score of a reached point: from 0 to 1, or the manipulability for `Measure.MANIPULABILITY`.

    The score is `UNUSABLE_SCORE` if the lever of the tool's force about a joint is beyond its limits.

    Args:
        measure: a `Measure`.
        elements: (n,) |k^T J|, lever of the tool force about each joint, in [m]; k is the unit tangent.
        rates: (n,) |J^-1 k|, turn of each joint for each metre of path, in [rad/m].
        spread: Yoshikawa's manipulability, in the units of the Jacobian.
        limits: (3, n) rows of low and high limits of the lever in [m], and of 2 / (high - low) in [1/m].
    """
    if measure == 0:
        return 1.0
    if measure == 1:
        return spread
    fast, strong = -1.0, 1.0
    for i in range(len(elements)):
        fast = max(fast, (elements[i] - limits[0, i]) * limits[2, i])
        strong = min(strong, (limits[1, i] - elements[i]) * limits[2, i])
    value = min(fast, strong)
    if measure == 3:
        for i in range(len(rates)):
            value = min(value, 1.0 - limits[0, i] * rates[i])
    if value <= 0.0:
        return UNUSABLE_SCORE
    return value
