"""Prediction of a trial's success and time from learned odds, with its uncertainty."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.evaluation.campaigns.walks.walk_table import WalkTable
from handcart.evaluation.campaigns.walks.walker import Walker
from handcart.networks.task.task_file import Task
from handcart.robotics.numerics.arrays import FloatArray

from .learned_odds import LearnedOdds
from .seen_actions import SeenActions

BOOTSTRAP_COUNT = 100
_WALKS = 4096  # for each bootstrap sample
_STREAM = 21


class Prediction(NamedTuple):
    """Probability of success and mean duration, in [s], that are predicted for a trial."""

    success: float
    time_s: float
    resampled: FloatArray
    """(`BOOTSTRAP_COUNT`, 2) predictions from bootstrap samples of the trials (Efron, 1979).

    Their spread shows how much the prediction depends on the trials that were seen.
    """

    @property
    def sigma(self) -> tuple[float, float]:
        """Standard errors of the success probability and the mean time in [s], from the bootstrap samples."""
        success, time_s = self.resampled.std(axis=0, ddof=1).tolist()
        return success, time_s

    @property
    def success_95(self) -> tuple[float, float]:
        """95 % bootstrap confidence interval of the probability of success."""
        low, high = np.quantile(self.resampled[:, 0], [0.025, 0.975]).tolist()
        return low, high

    @property
    def time_95_s(self) -> tuple[float, float]:
        """95 % bootstrap confidence interval of the mean time of a trial, in [s]."""
        low, high = np.quantile(self.resampled[:, 1], [0.025, 0.975]).tolist()
        return low, high


def predict(task: Task, seen: SeenActions) -> Prediction:
    """Predict the success and time of a task by random walks through its network of actions.

    Seeds are fixed, so that equal data gives equal predictions.

    Args:
        task: the task.
        seen: recorded actions, from which outcomes and durations are learned.
    """
    table, odds = WalkTable(task.network), LearnedOdds(task, seen)
    success, time_s = _walked(table, odds, 4 * _WALKS, 0)
    draws = np.random.default_rng([_STREAM, 0])
    count = len(seen.success)
    resampled = []
    for number in range(BOOTSTRAP_COUNT):
        again = seen.chosen(np.sort(draws.integers(0, count, count)))
        resampled.append(_walked(table, LearnedOdds(task, again, odds.pooling), _WALKS, 1 + number))
    return Prediction(success, time_s, np.array(resampled))


def _walked(table: WalkTable, odds: LearnedOdds, count: int, number: int) -> tuple[float, float]:
    walked = Walker(table, odds).walk(np.random.default_rng([_STREAM, 1, number]), count)
    return float(walked.success.mean()), float(walked.seconds.sum(axis=0).mean() + odds.rest_s)
