"""What `handcart check` reckons exactly, beside what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import gammaln, xlog1py, xlogy

from handcart.evaluation.campaigns.action_ends import action_names
from handcart.files.errors import InputError
from handcart.networks.analysis.figures import figures, missing_chances
from handcart.networks.chains.policy import TooLarge
from handcart.networks.task.task_file import load_task

UNLIKELY = 0.05


@dataclass(frozen=True)
class ExactValue:
    """P(goal), if the probabilities in the task's file are right; and whether the measured share fits."""

    goal: float
    p_value: float
    """Of the exact binomial test that it is the measured share's true value."""

    @property
    def agrees(self) -> bool:
        """Whether the measured share gives no reason to doubt it."""
        return self.p_value >= UNLIKELY


def exact_goal(task: Path, settings: Mapping[str, str]) -> float | str:
    """P(goal) of a task by its file's probabilities, or why there is none."""
    return exact_end(task, settings, "Success")


def exact_end(task: Path, settings: Mapping[str, str], outcome: str) -> float | str:
    """How likely a run ends with Success, Fail or GiveUp by its file's probabilities, or why nobody knows."""
    try:
        read = load_task(task, settings)
    except InputError:
        return "the task's file can't be read any more"
    if missing := missing_chances(read):
        count = len(missing)
        return f"{count} action{'s have' if count > 1 else ' has'} no probability `p` in the task's file"
    try:
        found = figures(read).forecast
    except TooLarge as error:
        return str(error)
    ends = {"Success": found.goal, "Fail": found.no_way + found.left_undone, "GiveUp": found.give_up}
    return ends[outcome]


def file_chances(task: Path, settings: Mapping[str, str]) -> dict[str, float]:
    """The probabilities of Success that stand in a task's file, by the action's name; none where it can't be
    read any more.
    """
    try:
        read = load_task(task, settings)
    except InputError:
        return {}
    named = zip(action_names(read), read.file.actions, strict=True)
    return {name: action.p for name, action in named if action.p is not None}


def beside(goal: float, successes: int, count: int) -> ExactValue:
    """The exact value beside a measured share."""
    return ExactValue(goal, _binomial_test(successes, count, min(1.0, max(0.0, goal))))


def _binomial_test(successes: int, count: int, p: float) -> float:
    """The p-value of the exact test of both sides: how likely counts are that are as unlikely as this."""
    numbers = np.arange(count + 1.0)
    ways = gammaln(count + 1.0) - gammaln(numbers + 1.0) - gammaln(count - numbers + 1.0)
    likely = np.exp(ways + xlogy(numbers, p) + xlog1py(count - numbers, -p))
    return min(1.0, float(likely[likely <= likely[successes] * (1.0 + 1e-7)].sum()))
