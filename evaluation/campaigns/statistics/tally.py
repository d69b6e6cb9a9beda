"""Counts over a campaign's trials, in one pass."""

from __future__ import annotations

import heapq
import math
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from handcart.evaluation.campaigns.data.trial import Trial

OUTCOME_NAMES = ("Success", "Fail", "GiveUp")
WORST_TRIAL_COUNT = 10
OF_ALL = ("sim_time_s", "actions", "fails")
"""Figures of each trial in addition to its task's metrics; the machine's time is not one of them."""
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?!\w)")


class Blame(NamedTuple):
    """Key by which a campaign's Fails and GiveUps are grouped and counted, with primitive, outcome and
    cause.
    """

    primitive: str
    outcome: str
    check: str
    """Check that found the cause, as in `Cause.check`; empty if unknown."""
    reason: str
    """Reason, with # for each number."""
    cause: str = ""
    """Kind of cause; empty if unknown."""


def in_general(reason: str) -> str:
    """Return a text with # in place of each number, so that texts that differ only in measured values are
    equal.
    """
    return _NUMBER.sub("#", reason)


def outcome_in_general(summary: Mapping[str, Any]) -> str:
    """Return the outcome of a trial and its reason, with numbers replaced by `#` so that similar trials are
    equal.
    """
    reason = in_general(summary["reason"])
    return str(summary["outcome"]) + (f": {reason}" if reason else "")


def figures(trial: Trial) -> dict[str, float | bool]:
    """Return those metrics of a trial that are finite numbers or booleans, by name.

    A trial whose process died has none.
    """
    if not trial.measured:
        return {}
    found = {**trial.summary["metrics"], **{key: trial.summary[key] for key in OF_ALL}}
    return {
        name: value
        for name, value in found.items()
        if isinstance(value, bool | int | float) and math.isfinite(value)
    }


class Tally:
    """Counts and metrics of a campaign's trials, collected in one pass (a few MB for 100,000 trials)."""

    def __init__(self, trials: Iterable[Trial]) -> None:
        self.count = self.successes = self.broken = 0
        self.outcomes: Counter[str] = Counter()
        """Counts of outcomes, with the general reason unless Success."""
        self.untrue: list[int] = []
        """Indices of the trials with an outcome that the ground truth contradicts."""
        self.columns: dict[str, array[float]] = {}
        """Values of each metric."""
        self.yes_no: set[str] = set()
        """Names of the yes-or-no metrics."""
        self.actions: dict[str, Counter[str]] = {}
        """Counts of outcomes of each action in the file."""
        self.blames: Counter[Blame] = Counter()
        self.worst: list[tuple[bool, bool, float, int]] = []
        """Ranks of the trials to look at first, the worst one first once all are counted; see `rank`."""
        self.times, self.timed = array("d"), array("q")
        """Durations of the successful trials, in [s], and the indices of these trials."""
        for at, trial in enumerate(trials):
            self._add(at, trial)
        self.worst.sort(reverse=True)

    @property
    def median_run(self) -> int | None:
        """Return the index of the successful trial with the median time; None without success."""
        if not self.timed:
            return None
        order = np.lexsort((np.asarray(self.timed), np.asarray(self.times)))
        return self.timed[int(order[(len(order) - 1) // 2])]

    def _add(self, at: int, trial: Trial) -> None:
        summary = trial.summary
        self.count += 1
        self.successes += trial.success
        self.broken += trial.broken
        self.outcomes[outcome_in_general(summary)] += 1
        if trial.untrue:
            self.untrue.append(at)
        if trial.success:
            self.times.append(summary["sim_time_s"])
            self.timed.append(at)
        for name, value in figures(trial).items():
            self.columns.setdefault(name, array("d")).append(value)
            if isinstance(value, bool):
                self.yes_no.add(name)
        for end in trial.actions:
            self.actions.setdefault(end.action, Counter())[end.outcome] += 1
            if end.outcome != "Success":
                reason = in_general(end.reason)
                self.blames[Blame(end.primitive, end.outcome, end.check, reason, end.cause)] += 1
        self._rank(at, trial)

    def _rank(self, at: int, trial: Trial) -> None:
        """Rank a trial among those to look at first: false outcomes, then trials without Success, then most
        Fails.
        """
        fails = float(trial.summary["fails"])
        if trial.untrue or not trial.success or fails:
            self.rank((bool(trial.untrue), not trial.success, fails, -at))

    def rank(self, rank: tuple[bool, bool, float, int]) -> None:
        """Add a trial to the list of the worst trials if it is among the worst `WORST_TRIAL_COUNT` so far.

        Args:
            rank: whether an outcome of the trial is false, whether the trial missed the goal, its number of
                Fails, and its index in the campaign, negated so that of equal trials the first is the worst.
        """
        (heapq.heappush if len(self.worst) < WORST_TRIAL_COUNT else heapq.heappushpop)(self.worst, rank)
