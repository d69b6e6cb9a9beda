"""Comparison of measured shares with the exact values that `handcart check` computes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import gammaln, xlog1py, xlogy

from handcart.evaluation.campaigns.data.action_ends import action_names
from handcart.files.errors import InputError
from handcart.networks.analysis.figures import figures, missing_chances
from handcart.networks.task.task_file import load_task

UNLIKELY_PROBABILITY = 0.05
MAX_EXACT_GAP = 1e-6
"""Probability left open by states that were not looked at, up to which a value counts as exact."""


@dataclass(frozen=True)
class ExactValue:
    """Probability of the goal by the task's file, and how well the share of successful trials agrees."""

    goal: float
    p_value: float
    """p-value of the exact binomial test that this is the true value of the measured share."""

    @property
    def agrees(self) -> bool:
        """True if the share of successful trials agrees with the exact probability (p-value 0.05 or more)."""
        return self.p_value >= UNLIKELY_PROBABILITY


def exact_goal(task: Path, settings: Mapping[str, str]) -> float | str:
    """Return the probability that a task reaches its goal, or the reason why it is unknown, as text.

    The probabilities in the task's file are used; `settings` has values of the task's parameters, by name.
    """
    return exact_end(task, settings, "Success")


def exact_end(task: Path, settings: Mapping[str, str], outcome: str) -> float | str:
    """Return the probability that a run ends with an outcome, by the probabilities in the task's file.

    Args:
        task: the task's file.
        settings: values of the task's parameters, by name.
        outcome: Success, Fail or GiveUp.

    Returns:
        The probability, or a text that says why it is unknown.
    """
    try:
        read = load_task(task, settings)
    except InputError:
        return "the task's file can't be read any more"
    if missing := missing_chances(read):
        count = len(missing)
        return f"{count} action{'s have' if count > 1 else ' has'} no probability `p` in the task's file"
    found = figures(read).forecast
    if found.unknown > MAX_EXACT_GAP:
        return f"between {found.goal:.5f} and {found.goal_high:.5f} for the goal: too many states"
    ends = {"Success": found.goal, "Fail": found.no_way + found.left_undone, "GiveUp": found.give_up}
    return ends[outcome]


def file_chances(task: Path, settings: Mapping[str, str]) -> dict[str, float]:
    """Return the probability of Success that a task's file states for each action, by the action's name.

    The result is empty if the file cannot be read.
    """
    try:
        read = load_task(task, settings)
    except InputError:
        return {}
    named = zip(action_names(read), read.file.actions, strict=True)
    return {name: action.p_success for name, action in named if action.p_success is not None}


def compare_share(goal: float, successes: int, count: int) -> ExactValue:
    """Test by the exact binomial test whether a share of successes contradicts P(goal).

    Args:
        goal: P(goal) by the probabilities in the task's file.
        successes: number of successful trials.
        count: number of trials.
    """
    return ExactValue(goal, _binomial_test(successes, count, min(1.0, max(0.0, goal))))


def _binomial_test(successes: int, count: int, p: float) -> float:
    """Return the two-sided p-value of the exact binomial test."""
    numbers = np.arange(count + 1.0)
    ways = gammaln(count + 1.0) - gammaln(numbers + 1.0) - gammaln(count - numbers + 1.0)
    likely = np.exp(ways + xlogy(numbers, p) + xlog1py(count - numbers, -p))
    return min(1.0, float(likely[likely <= likely[successes] * (1.0 + 1e-7)].sum()))
