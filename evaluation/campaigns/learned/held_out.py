"""Cross-validation of learned odds on trials that were not used for learning."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.special import erfc

from handcart.networks.task.task_file import Task

from .prediction import predict
from .seen_actions import SeenActions

SIGNIFICANCE_LEVEL = 0.01
"""Maximum probability of rejecting correct odds."""


class HeldOut(NamedTuple):
    """A quantity measured in one half of the trials, and its prediction from the other half."""

    name: str
    predicted: float
    measured: float
    p_value: float
    """Probability of a difference at least as large if both halves are alike (normal, both errors added)."""


class Trust(NamedTuple):
    """Result of a two-fold cross-validation of learned probabilities.

    It has one comparison with the measured value for each predicted probability.
    """

    tried: tuple[HeldOut, ...]

    @property
    def wrong(self) -> HeldOut | None:
        """The prediction, among all that were tested, that differs most significantly from the measured
        trials.

        None if no difference is significant.

        The level of significance is corrected for the number of predictions (Bonferroni).
        """
        worst = min(self.tried, key=lambda item: item.p_value)
        return worst if worst.p_value * len(self.tried) < SIGNIFICANCE_LEVEL else None


def hold_out(task: Task, seen: SeenActions) -> Trust:
    """Cross-validate learned probabilities: learn from each half of the trials, and predict the other half.

    One half are the trials with even indices, the other half those with odd indices.

    Args:
        task: the task of the trials.
        seen: the actions of at least four trials.
    """
    numbers = np.arange(len(seen.success))
    halves = [seen.chosen(numbers[numbers % 2 == number]) for number in (0, 1)]
    tried: list[HeldOut] = []
    for learned, other in (halves, halves[::-1]):
        found = predict(task, learned)
        pairs = zip(("P(goal)", "mean time [s]"), (found.success, found.time_s), found.sigma, strict=True)
        for (name, value, sigma), measured in zip(pairs, (other.success, other.time_s), strict=True):
            spread = measured.std(ddof=1) / math.sqrt(len(measured))
            apart = abs(float(measured.mean()) - value)
            error = math.hypot(sigma, spread)
            p = float(erfc(apart / error / math.sqrt(2.0))) if error > 0.0 else float(apart < 1e-9)
            tried.append(HeldOut(name, value, float(measured.mean()), p))
    return Trust(tuple(tried))
