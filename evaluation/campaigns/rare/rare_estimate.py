"""Estimate of a rare probability from the populations of a campaign."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from handcart.evaluation.campaigns.data.trial import Trial

from .population import Level, Population

INTERVAL_ERROR_RATE = 0.05
"""Share of the confidence intervals that may miss the true value."""


class LevelSeen(NamedTuple):
    """Counts of the runs that started at one level of multilevel splitting, summed over all populations."""

    share: float
    """Estimated share of all runs that reach the level."""
    runs: int
    """Number of runs that started at the level."""
    reached: int
    """Number of these runs that reached the next level."""
    hits: int
    """Number of these runs that ended with the rare outcome before the next level."""

    @property
    def part(self) -> float:
        """Part of the rare outcome's probability that comes from the runs started at this level (stage before
        the rare outcome), estimated from all populations of runs together.
        """
        return self.share * self.hits / max(1, self.runs)

    @property
    def unseen(self) -> float:
        """Upper bound (95 %) of this level's contribution to the rare outcome's probability in multilevel
        splitting.

        It is 0 if a run that started at the level had the rare outcome, because the contribution is then
        estimated.
        """
        return (
            0.0 if self.hits else self.share * -math.expm1(math.log(INTERVAL_ERROR_RATE) / max(1, self.runs))
        )


@dataclass(frozen=True)
class RareEstimate:
    """Estimate of the probability of a rare outcome from independent populations of simulated runs."""

    probability: float
    low: float | None
    """Lower end of the 95 % interval; None for a single population, or if no population had a hit."""
    high: float | None
    """Upper end of the 95 % interval; None as for `low`."""
    sigma: float
    """Standard error of the probability, from the spread of the populations."""
    levels: tuple[LevelSeen, ...]
    steps: int
    """Number of actions that were started."""
    steps_of_a_run: float
    """Mean number of actions in a complete run."""

    @classmethod
    def of(cls, trials: Iterable[Trial]) -> RareEstimate:
        """Estimate the probability of a rare outcome from a campaign's trials; without any trial it is 0.

        Trials whose process died have no population, and are left out.
        """
        populations = [
            Population(tuple(Level(*level) for level in trial.summary["metrics"]["levels"]))
            for trial in trials
            if "levels" in trial.summary["metrics"]
        ]
        found = np.array([population.probability for population in populations] or [0.0])
        count, mean = len(found), float(found.mean())
        sigma = float(found.std(ddof=1) / math.sqrt(count)) if count > 1 else math.inf
        low, high = interval(mean, sigma, count) or (None, None)
        steps_of_a_run = sum(population.steps_of_a_run for population in populations) / max(
            1, len(populations)
        )
        steps = sum(population.steps for population in populations)
        return cls(mean, low, high, sigma, _levels(populations), steps, steps_of_a_run)

    @property
    def unseen(self) -> float:
        """Largest upper bound (95 %) of the rare outcome's probability at the levels where no run had this
        outcome.

        Each bound is for the contribution of one level of multilevel splitting; 1 without any level.
        """
        return max((level.unseen for level in self.levels), default=1.0)

    @property
    def worth(self) -> float:
        """Number of trials without splitting that would give the probability with the same standard error.

        It is 0 if no standard error is known.
        """
        if not self.probability or not 0.0 < self.sigma < math.inf:
            return 0.0
        return self.probability * (1.0 - self.probability) / self.sigma**2

    @property
    def cost(self) -> float:
        """Cost of the estimate, as the number of complete runs from the start that would start as many
        actions.
        """
        return self.steps / self.steps_of_a_run if self.steps_of_a_run else 0.0

    def agrees(self, exact: float) -> bool:
        """Return whether an exact value is within the estimate's 95 % interval.

        Without an interval, return whether it is at most the upper bound.
        """
        if self.low is None or self.high is None:
            return exact <= self.probability + self.unseen
        return self.low <= exact <= self.high


def interval(mean: float, sigma: float, count: int) -> tuple[float, float] | None:
    """Return the 95 % interval of a positive probability, by Student's t distribution of its logarithm.

    A probability that is a product of shares has a skewed distribution; that of its logarithm is less skewed.
    The standard error of the logarithm follows by the delta method.

    Args:
        mean: mean of independent estimates.
        sigma: standard error of the mean.
        count: number of estimates.

    Returns:
        Lower and upper end, at most 1; None if the mean is not positive, or there are fewer than two.
    """
    if count < 2 or mean <= 0.0:
        return None
    factor = math.exp(float(stdtrit(count - 1, 1.0 - INTERVAL_ERROR_RATE / 2.0)) * sigma / mean)
    return mean / factor, min(1.0, mean * factor)


def _levels(populations: Sequence[Population]) -> tuple[LevelSeen, ...]:
    """Return each level, added up over all populations."""
    seen = []
    for number in range(max((len(population.levels) for population in populations), default=0)):
        there = [population for population in populations if number < len(population.levels)]
        share = sum(population.weights[number] for population in there) / len(populations)
        at = [population.levels[number] for population in there]
        runs, reached, hits = (sum(level[place] for level in at) for place in range(3))
        seen.append(LevelSeen(share, runs, reached, hits))
    return tuple(seen)
