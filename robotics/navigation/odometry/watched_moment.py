"""States of a Kalman filter at a past moment, cloned next to the present ones, so that later readings correct
them.

Roumeliotis and Burdick (2002), stochastic cloning; the same algebra is fixed-point smoothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled
from handcart.robotics.numerics.small_solve import solved


class Belief(NamedTuple):
    """Mean and covariance of the states of a filter or a smoother."""

    mean: FloatArray
    """Mean (n,) of the states."""
    covariance: FloatArray
    """Covariance (n, n) of the states."""


class BeliefBranch(NamedTuple):
    """One possible explanation of a sensor's reading, kept by a filter, with its probability.

    Each explanation assumes a different change of the filter's states just before the reading, for example
    slip, or no change.
    """

    weight: float
    """Probability of the branch, given the readings; all weights add up to one."""
    transition: FloatArray | None
    """Transition (n, n) of the states by the change; None without a change."""
    covariance: FloatArray
    """Covariance (n, n) of the states after the change."""
    residual: FloatArray
    """Residual (m,) of the readings after the change."""
    mean: FloatArray
    """Mean (n,) of the states after the update."""


class WatchedMoment(NamedTuple):
    """Estimate of a filter's states at an earlier moment, which later readings still improve.

    Of all earlier states only those at this moment are kept, with their covariance with the present states.
    """

    belief: Belief
    """Mean (k,) and covariance (k, k) of the states then."""
    shared: FloatArray
    """(k, n) covariance of the states then (rows) with those now."""

    @classmethod
    def of(cls, now: Belief, states: int | None = None) -> Self:
        """Return an estimate of the states at the present time, which later readings can improve.

        Args:
            now: belief with mean and covariance of the present states.
            states: number of the states to keep, the first ones; None: all.
        """
        covariance = now.covariance[:states].copy()
        return cls(Belief(now.mean[:states].copy(), covariance[:, :states].copy()), covariance)

    def stepped(self, transition: FloatArray) -> Self:
        """Return this estimate of earlier states after a prediction step of the filter. The step leaves the
        estimate unchanged; it changes the covariance with the present states.

        Args:
            transition: (n, n) transition of the present states in this step, in any units.
        """
        return type(self)(self.belief, self.shared @ transition.T)

    def corrected(
        self, covariance: FloatArray, rows: FloatArray, residual: FloatArray, variance: float
    ) -> Self:
        """Return the estimate of the states at the watched moment after a filter update by later readings.

        Args:
            covariance: (n, n) of the present states before the readings, in their units squared.
            rows: (m, n) derivative of the readings by the present states.
            residual: (m,) readings less their expected values, in their unit.
            variance: variance of each reading, in its unit squared.
        """
        (mean, spread), shared = self
        mean, spread, shared = _corrected(mean, spread, shared, covariance, rows, residual, variance)
        return type(self)(Belief(mean, spread), shared)

    def corrected_either(self, branches: Sequence[BeliefBranch], rows: FloatArray, variance: float) -> Self:
        """Return the estimate of the earlier states, improved by later readings before which the states may
        have changed in one of several ways.

        Args:
            branches: possible changes before the update, each with its weight, transition, residual and
                covariance.
            rows: (m, n) derivative of the readings by the present states.
            variance: variance of each reading, in its unit squared.
        """
        each = [
            (self if one.transition is None else self.stepped(one.transition)).corrected(
                one.covariance, rows, one.residual, variance
            )
            for one in branches
        ]
        weights = np.array([one.weight for one in branches])
        then = mixed([one.belief for one in each], weights)
        now = weights @ np.array([one.mean for one in branches])
        shared = sum(
            one.weight * (seen.shared + np.outer(seen.belief.mean - then.mean, one.mean - now))
            for one, seen in zip(branches, each, strict=True)
        )
        return type(self)(then, np.asarray(shared))

    def unrelated(self) -> Self:
        """Return a copy of this estimate of past states without correlation to the present states, so that
        later readings no longer change it.
        """
        return self._replace(shared=np.zeros_like(self.shared))

    def relative_pose(self, now: Belief) -> Belief:
        """Return the present pose relative to the pose at the tracked moment, with mean (3,) and covariance
        (3, 3).

        The values are x, y in [m] and heading in [rad], in the frame of the pose at the tracked moment.

        The first three states of `now` and of the tracked moment have to be x, y and heading. The heading of
        the mean isn't wrapped.

        Errors common to both moments cancel, and the absolute heading does not matter.
        """
        x, y, heading = self.belief.mean[:3].tolist()
        cos, sin = math.cos(heading), math.sin(heading)
        turned = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        mean = turned @ (now.mean[:3] - (x, y, heading))
        by_then = -turned
        by_then[:2, 2] = mean[1], -mean[0]
        both = by_then @ self.shared[:3, :3] @ turned.T
        spread = turned @ now.covariance[:3, :3] @ turned.T
        spread = spread + by_then @ self.belief.covariance[:3, :3] @ by_then.T + both + both.T
        return Belief(mean, 0.5 * (spread + spread.T))


def mixed(beliefs: Sequence[Belief], weights: FloatArray) -> Belief:
    """Return mean and covariance of a mixture of beliefs.

    Args:
        beliefs: k beliefs of the same n states, in any units.
        weights: (k,) probabilities; their sum is 1.
    """
    means, covariances = (
        np.array([belief.mean for belief in beliefs]),
        np.array([b.covariance for b in beliefs]),
    )
    mean = weights @ means
    return Belief(mean, spread_about(means - mean, weights, covariances, weights))


@compiled
def spread_about(
    away: FloatArray, weights: FloatArray, covariances: FloatArray, shares: FloatArray
) -> FloatArray:
    """Return the covariance (n, n) of a mixture, in units of the states squared.

    Args:
        away: (k, n) mean of each part less the mean of the mixture.
        weights: (k,) weights of the parts' means, with which the squares of `away` are added up.
        covariances: (k, n, n) covariances of the parts.
        shares: (k,) weights of the parts' covariances.
    """
    out = np.zeros(covariances.shape[1:])
    size = away.shape[1]
    for k in range(len(weights)):
        for i in range(size):
            for j in range(size):
                out[i, j] += shares[k] * covariances[k, i, j] + weights[k] * away[k, i] * away[k, j]
    return out


@compiled
def _corrected(
    mean: FloatArray,
    spread: FloatArray,
    shared: FloatArray,
    covariance: FloatArray,
    rows: FloatArray,
    residual: FloatArray,
    variance: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mean (k,), covariance (k, k) and shared covariance (k, n) of the states then, after readings."""
    seen = rows @ covariance @ rows.T + variance * np.eye(len(residual))
    gain = solved(seen, rows @ shared.T).T
    spread = spread - gain @ seen @ gain.T
    shared = shared - gain @ (rows @ covariance)
    return mean + gain @ residual, 0.5 * (spread + spread.T), shared
