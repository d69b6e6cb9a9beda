"""What the populations of a campaign say of a rare event."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from handcart.evaluation.campaigns.trial import Trial

from .population import Level, Population

ERROR = 0.05
"""Share of the intervals that may miss the true value."""


class LevelSeen(NamedTuple):
    """A level, over all populations."""

    share: float
    """Of all runs, that come to it."""
    runs: int
    """That began there."""
    reached: int
    """Of them, that came to the next one."""
    hits: int
    """Of them, that ended as is asked for without coming there."""

    @property
    def part(self) -> float:
        """What it adds to the probability, if all populations are alike."""
        return self.share * self.hits / max(1, self.runs)

    @property
    def unseen(self) -> float:
        """What it may add at most (95 %) although it wasn't seen; 0 where it was."""
        return 0.0 if self.hits else self.share * -math.expm1(math.log(ERROR) / max(1, self.runs))


@dataclass(frozen=True)
class RareEstimate:
    """How often runs end as is asked for, by independent populations."""

    probability: float
    low: float | None
    """Lower end of the 95 % interval; None: one population bounds nothing, nor do some that saw nothing."""
    high: float | None
    """Its upper end."""
    sigma: float
    """Of the probability, as the spread of the populations shows it."""
    levels: tuple[LevelSeen, ...]
    steps: int
    """Actions that were started."""
    steps_of_a_run: float
    """Actions that a run starts on average, from its beginning to its end."""

    @classmethod
    def of(cls, trials: Iterable[Trial]) -> RareEstimate:
        """By the trials of a campaign that asks for a rare event; of none at all it is 0."""
        populations = [
            Population(tuple(Level(*each) for each in trial.summary["metrics"]["levels"])) for trial in trials
        ]
        found = np.array([each.probability for each in populations] or [0.0])
        count, mean = len(found), float(found.mean())
        sigma = float(found.std(ddof=1) / math.sqrt(count)) if count > 1 else math.inf
        low, high = interval(mean, sigma, count) or (None, None)
        steps_of_a_run = sum(each.steps_of_a_run for each in populations) / max(1, len(populations))
        steps = sum(each.steps for each in populations)
        return cls(mean, low, high, sigma, _levels(populations), steps, steps_of_a_run)

    @property
    def unseen(self) -> float:
        """What ends may add at most (95 %) that come straight from a level from which none was seen."""
        return max((level.unseen for level in self.levels), default=1.0)

    @property
    def worth(self) -> float:
        """So many plain trials would have told as much; 0 where nobody can say."""
        if not self.probability or not 0.0 < self.sigma < math.inf:
            return 0.0
        return self.probability * (1.0 - self.probability) / self.sigma**2

    @property
    def cost(self) -> float:
        """As many plain trials would have started as many actions."""
        return self.steps / self.steps_of_a_run if self.steps_of_a_run else 0.0

    def agrees(self, exact: float) -> bool:
        """Whether it gives no reason to doubt an exact value."""
        if self.low is None or self.high is None:
            return exact <= self.probability + self.unseen
        return self.low <= exact <= self.high


def interval(mean: float, sigma: float, count: int) -> tuple[float, float] | None:
    """95 % interval of a mean that can't be below 0: Student's of its logarithm, by the delta method.

    A probability that is a product of shares is skewed, its logarithm less so. None: nothing bounds it.

    Args:
        mean: of independent estimates.
        sigma: of the mean.
        count: how many they are.
    """
    if count < 2 or mean <= 0.0:
        return None
    factor = math.exp(float(stdtrit(count - 1, 1.0 - ERROR / 2.0)) * sigma / mean)
    return mean / factor, mean * factor


def _levels(populations: Sequence[Population]) -> tuple[LevelSeen, ...]:
    """Each level, added up."""
    seen = []
    for number in range(max((len(each.levels) for each in populations), default=0)):
        there = [each for each in populations if number < len(each.levels)]
        share = sum(each.weights[number] for each in there) / len(populations)
        at = [each.levels[number] for each in there]
        runs, reached, hits = (sum(level[place] for level in at) for place in range(3))
        seen.append(LevelSeen(share, runs, reached, hits))
    return tuple(seen)
