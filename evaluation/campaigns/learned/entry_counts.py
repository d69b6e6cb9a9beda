"""Counts of how the actions of a task's file ended in recorded trials, with times and causes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import betaincinv, stdtrit

from handcart.evaluation.campaigns.data.action_ends import action_names
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.walks.odds import EndCode
from handcart.networks.deciding.posterior import OutcomeCounts
from handcart.networks.entries.entry import TaskEntry
from handcart.networks.task.task_file import Task
from handcart.robotics.numerics.arrays import FloatArray

from .seen_actions import FAULT_STATUS, SeenActions

CONFIDENCE_LEVEL = 0.95
MIN_P, MAX_P = 0.001, 0.999
"""Smallest and largest probability that is written: no number of attempts proves that an action always fails,
or never.
"""

DURATION_STEP_S = 1e-6
"""Difference up to which two durations are equal: they are differences of times that were rounded."""


class LearnedShare(NamedTuple):
    """Probability, learned from trials, that an action fails by one cause or succeeds with one result."""

    seen: int
    """Number of attempts that ended with this cause or result."""
    p: float
    """Expected probability, rounded as in a task file."""
    p_95: tuple[float, float]
    """95 % interval of the probability, from quantiles of its posterior."""


@dataclass(frozen=True)
class EntryCounts:
    """Outcomes, causes and durations of one action of a task file, counted over trials."""

    counts: OutcomeCounts
    causes: dict[str, int]
    """Number of Fails and GiveUps of each kind of cause."""
    mean_s: float
    """Mean duration of an attempt, in [s]; NaN without attempts."""
    mean_95_s: tuple[float, float]
    """95 % interval of the mean duration, in [s], by Student's t; NaN if all durations are equal."""
    named: tuple[str, ...] = ()
    """Causes that `on_fail` names, in the order of `OutcomeCounts.by_cause`."""

    @property
    def p(self) -> float:
        """Probability of Success, estimated from counted outcomes, rounded to 3 decimals as in a task
        file.
        """
        return min(MAX_P, max(MIN_P, round(self.counts.chance.success, 3)))

    @property
    def p_give_up(self) -> float:
        """Estimated probability of GiveUp, rounded as in a task file; 0 if no attempt ended in GiveUp."""
        if not self.counts.give_ups:
            return 0.0
        return round(min(self.counts.chance.give_up, 1.0 - self.p), 4)

    @property
    def p_95(self) -> tuple[float, float]:
        """95 % interval of the probability of Success: quantiles of its posterior, a Beta distribution."""
        return self._interval(self.counts.weights[0])

    @property
    def by_cause(self) -> dict[str, LearnedShare]:
        """Probability of a Fail by each cause in the action's `on_fail`; empty without recorded causes."""
        counts = self.counts
        if not counts.by_cause:
            return {}
        _, *shares = counts.chance.fail_shares
        left = 1.0 - self.p - self.p_give_up
        rows = zip(self.named, counts.by_cause, shares, counts.fail_weights[1:], strict=True)
        return {
            name: LearnedShare(count, _floored(left * share), self._interval(weight))
            for name, count, share, weight in rows
        }

    @property
    def by_result(self) -> list[LearnedShare]:
        """Probability of each result that the action returned with Success, the usual result first.

        It is empty without recorded results.
        """
        counts = self.counts
        rows = zip(counts.by_result, counts.chance.success_shares, counts.result_weights, strict=True)
        return [
            LearnedShare(count, _floored(self.p * share), self._interval(weight))
            for count, share, weight in rows
        ]

    def _interval(self, weight: float) -> tuple[float, float]:
        """Return the interval of a probability with this weight among those of all outcomes."""
        beside = (1.0 - CONFIDENCE_LEVEL) / 2.0
        others = sum(self.counts.weights) - weight
        low, high = betaincinv(weight, others, np.array([beside, 1.0 - beside])).tolist()
        return low, high

    def words(self) -> str:
        """Return the recorded outcomes of an action as text, for a comment next to the action in the task's
        file.
        """
        low, high = self.p_95
        shares, parts = self.by_cause, list[str]()
        for name, count in sorted({**dict.fromkeys(shares, 0), **self.causes}.items()):
            interval = "p {:.3f} to {:.3f}".format(*shares[name].p_95) if name in shares else ""
            parts.append(f"{name} {count}{f' ({interval})' * bool(interval)}")
        also = f"; {', '.join(parts)}" if parts else ""
        return f"{self.counts.successes} of {self.counts.attempts}, p {low:.3f} to {high:.3f}{also}"


def count_entries(task: Task, trials: Iterable[Trial]) -> list[EntryCounts]:
    """Count how each action of a task's file ended in trials.

    Trials that ended by a fault of the program do not count. The counts are in the order of the file.
    """
    kept = list(trials)
    seen = SeenActions.of(task, kept)
    numbers = {name: number for number, name in enumerate(action_names(task))}
    ends: list[list[ActionEnd]] = [[] for _ in numbers]
    for trial in kept:
        if trial.status == FAULT_STATUS:
            continue
        for end in trial.actions:
            if end.action in numbers:
                ends[numbers[end.action]].append(end)
    entries = task.file.actions
    return [_counted(seen, number, entry, ends[number]) for number, entry in enumerate(entries)]


def _counted(seen: SeenActions, number: int, entry: TaskEntry, all_ends: Sequence[ActionEnd]) -> EntryCounts:
    rows = seen.entry == number
    ends = Counter(seen.end[rows].tolist())
    fails = ends[EndCode.FAIL] + ends[EndCode.FOR_GOOD]
    causes = dict(Counter(end.cause for end in all_ends if end.cause))
    named = tuple(entry.fail_entries)
    by_cause, by_result = _fails_by_cause(named, all_ends), _successes_by_result(entry, all_ends)
    outcomes = ends[EndCode.SUCCESS], fails, ends[EndCode.GIVE_UP]
    counts = OutcomeCounts(*outcomes, by_cause, by_result)
    seconds = seen.seconds[rows]
    if not len(seconds):
        return EntryCounts(counts, causes, math.nan, (math.nan, math.nan), named)
    return EntryCounts(counts, causes, float(seconds.mean()), _mean_interval(seconds), named)


def _mean_interval(seconds: FloatArray) -> tuple[float, float]:
    """Return the 95 % interval of the mean of durations (n,), in [s]; NaN if none differ: their spread is
    unknown.
    """
    if not np.ptp(seconds) > DURATION_STEP_S:
        return math.nan, math.nan
    mean, error = float(seconds.mean()), float(seconds.std(ddof=1)) / math.sqrt(len(seconds))
    reach = float(stdtrit(len(seconds) - 1, 0.5 * (1.0 + CONFIDENCE_LEVEL))) * error
    return max(0.0, mean - reach), mean + reach


def _fails_by_cause(named: Sequence[str], ends: Sequence[ActionEnd]) -> tuple[int, ...]:
    """Return the number of Fails of each named cause; empty if the causes of some were not recorded."""
    causes = [end.cause for end in ends if end.outcome == "Fail"]
    return () if "" in causes else tuple(causes.count(name) for name in named)


def _successes_by_result(entry: TaskEntry, ends: Sequence[ActionEnd]) -> tuple[int, ...]:
    """Return the number of Successes of each effect; empty if there is one, or if they were not recorded."""
    results = [end.result for end in ends if end.outcome == "Success"]
    others = [ending.result for ending in entry.endings[1:]]
    if entry.is_plain or None in results:
        return ()
    counts = [results.count(name) for name in others]
    return (len(results) - sum(counts), *counts)


def _floored(p: float) -> float:
    """Return a probability as it is written, rounded down, so that the sum of several stays in its limit."""
    return math.floor(p * 1e4 + 1e-6) / 1e4
