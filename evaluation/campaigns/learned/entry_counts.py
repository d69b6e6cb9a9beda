"""Counts of how the actions of a task's file ended in recorded trials, with times and causes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import betaincinv

from handcart.evaluation.campaigns.data.action_ends import action_names
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.walks.odds import EndCode
from handcart.networks.deciding.posterior import OutcomeCounts
from handcart.networks.task.task_file import Task

from .seen_actions import SeenActions

CONFIDENCE_LEVEL = 0.95
MAX_P = 0.999
"""Largest probability that is written: no number of attempts proves that an action never fails."""


@dataclass(frozen=True)
class EntryCounts:
    """Outcomes, causes and durations of one action of a task file, counted over trials."""

    counts: OutcomeCounts
    causes: dict[str, int]
    """Number of Fails and GiveUps of each kind of cause."""
    mean_s: float
    """Mean duration of an attempt, in [s]; NaN without attempts."""
    mean_95_s: tuple[float, float]
    """Interval of the mean duration."""

    @property
    def p(self) -> float:
        """Expected probability of Success, rounded as in a task file."""
        return min(MAX_P, round(self.counts.chance.success, 3))

    @property
    def p_give_up(self) -> float:
        """Expected probability of GiveUp, rounded as in a task file; 0 if no attempt gave up."""
        if not self.counts.give_ups:
            return 0.0
        return round(min(self.counts.chance.give_up, 1.0 - self.p), 4)

    @property
    def p_95(self) -> tuple[float, float]:
        """Interval of the probability of Success: quantiles of its posterior, a Beta distribution."""
        success, fail, give_up = self.counts.weights
        beside = (1.0 - CONFIDENCE_LEVEL) / 2.0
        low, high = betaincinv(success, fail + give_up, np.array([beside, 1.0 - beside])).tolist()
        return low, high

    def words(self) -> str:
        """Return the counts as text of a comment next to the action."""
        low, high = self.p_95
        causes = ", ".join(f"{name} {count}" for name, count in sorted(self.causes.items()))
        also = f"; {causes}" if causes else ""
        return f"{self.counts.successes} of {self.counts.attempts}, p {low:.3f} to {high:.3f}{also}"


def count_entries(task: Task, trials: Iterable[Trial]) -> list[EntryCounts]:
    """Count the ends of each action of a task's file.

    Trials that ended by a fault of the program do not count.
    """
    kept = list(trials)
    seen = SeenActions.of(task, kept)
    numbers = {name: number for number, name in enumerate(action_names(task))}
    causes: list[Counter[str]] = [Counter() for _ in numbers]
    for trial in kept:
        for end in trial.actions:
            if end.cause and end.action in numbers:
                causes[numbers[end.action]][end.cause] += 1
    return [_counted(seen, number, dict(each)) for number, each in enumerate(causes)]


def _counted(seen: SeenActions, number: int, causes: dict[str, int]) -> EntryCounts:
    rows = seen.entry == number
    ends = Counter(seen.end[rows].tolist())
    fails = ends[EndCode.FAIL] + ends[EndCode.FOR_GOOD]
    counts = OutcomeCounts(ends[EndCode.SUCCESS], fails, ends[EndCode.GIVE_UP])
    seconds = seen.seconds[rows]
    if not len(seconds):
        return EntryCounts(counts, causes, math.nan, (math.nan, math.nan))
    mean = float(seconds.mean())
    spread = float(seconds.std(ddof=1)) / math.sqrt(len(seconds)) if len(seconds) > 1 else 0.0
    return EntryCounts(counts, causes, mean, (mean - 1.96 * spread, mean + 1.96 * spread))
