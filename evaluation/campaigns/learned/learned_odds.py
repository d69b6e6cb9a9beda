"""Odds of actions, estimated from recorded trials."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.evaluation.campaigns.walks.odds import CONTEXT_COUNT, EndCode
from handcart.networks.task.task_file import Task
from handcart.robotics.numerics.arrays import FloatArray, Int8Array, Int32Array, IntArray

from .seen_actions import SeenActions

KNOWN_ENDS = len(EndCode) - 1  # ends that can be observed
POOLING_WEIGHTS = (1.0, 3.0, 10.0, 30.0, 100.0, 1e9)
_FOLDS = 5
_ENOUGH = 20  # durations seen in a context, from which other contexts are not used
_LEAST = 1e-4  # probability of an unseen end, when likelihoods are compared


class LearnedOdds:
    """Probabilities of each action's outcomes and durations, learned from trials by context.

    The context is the number of the action's earlier Fails and whether the action before it failed. Rare
    contexts are pooled with the others: the share of an outcome in a context is (its count + w times its
    share in all contexts) / (the context's count + w), the mean of a Dirichlet posterior, where w is the
    weight of the pooling. Durations are drawn from those recorded with the same outcome.
    """

    def __init__(self, task: Task, seen: SeenActions, pooling: float | None = None) -> None:
        """Estimate the odds of a task's actions.

        Args:
            task: the task; its actions may be connected differently than in the trials.
            seen: the actions of at least one trial.
            pooling: the weight w; None: the one of `POOLING_WEIGHTS` with the largest cross-validated
                likelihood.
        """
        self.pooling = best_pooling(task, seen) if pooling is None else pooling
        self._entry = np.array([-1 if entry is None else entry for entry in task.entries], dtype=np.int64)
        shares = _shares(_counts(task, seen), self.pooling)
        self._limits = np.cumsum(shares, axis=2)
        self._known = shares.sum(axis=(1, 2)) > 0.0
        self._drawers = _Drawers.of(len(task.file.actions), seen)
        self.rest_s = float(seen.rest_s.mean())

    def unknown(self, entry: int) -> bool:
        """Return whether an action of the task's file was never started in the trials from which the
        probabilities were learned.
        """
        return not self._known[entry]

    def ends(self, action: Int32Array, context: Int32Array, drawn: FloatArray) -> Int8Array:
        """Draw how each action ends, as an `EndCode` (n,), with the probabilities learned from a campaign.

        Args:
            action: (n,) indices of the actions in the network.
            context: (n,) code, by `context_of`, of how often the action failed before and whether the walk's
                latest action failed.
            drawn: (n,) random numbers, uniform in [0, 1).
        """
        entry = self._entry[action]
        ends = (drawn[:, None] >= self._limits[entry, context, : KNOWN_ENDS - 1]).sum(axis=1)
        return np.where(self._known[entry], ends, EndCode.UNKNOWN).astype(np.int8)

    def seconds(
        self, action: Int32Array, context: Int32Array, ends: Int8Array, drawn: FloatArray
    ) -> FloatArray:
        """Draw durations (n,) in [s] as learned from a campaign; 0 for actions without data.

        Args:
            action: (n,) indices of the actions in the network.
            context: (n,) code, by `context_of`, of how often the action failed before, and whether the latest
                action of the same random walk failed.
            ends: (n,) how the actions end, as an `EndCode`.
            drawn: (n,) random numbers, uniform in [0, 1).
        """
        seconds = np.zeros(len(action))
        known = ends != EndCode.UNKNOWN
        entry = self._entry[action[known]]
        seconds[known] = self._drawers.draw(entry, context[known], ends[known], drawn[known])
        return seconds


class _Drawers(NamedTuple):
    """Recorded durations, grouped by action, context and end."""

    seconds: FloatArray
    begin: IntArray
    """(entries, contexts, ends) start index of each group in `seconds`."""
    held: IntArray
    """(entries, contexts, ends) size of each group."""

    @classmethod
    def of(cls, entries: int, seen: SeenActions) -> _Drawers:
        shape = (entries, CONTEXT_COUNT, KNOWN_ENDS)
        own = np.ravel_multi_index((seen.entry, seen.context, seen.end), shape)
        every = np.ravel_multi_index((seen.entry, seen.end), (entries, KNOWN_ENDS))
        own_count = np.bincount(own, minlength=int(np.prod(shape))).reshape(shape)
        all_count = np.bincount(every, minlength=entries * KNOWN_ENDS).reshape(entries, 1, KNOWN_ENDS)
        own_begin = (np.cumsum(own_count) - own_count.ravel()).reshape(shape)
        all_begin = len(own) + (np.cumsum(all_count) - all_count.ravel()).reshape(all_count.shape)
        order = (np.argsort(item, kind="stable") for item in (own, every))
        enough = own_count >= _ENOUGH
        return cls(
            np.concatenate([seen.seconds[item] for item in order]),
            np.where(enough, own_begin, all_begin),
            np.where(enough, own_count, all_count),
        )

    def draw(self, entry: IntArray, context: Int32Array, ends: Int8Array, drawn: FloatArray) -> FloatArray:
        at = entry, context, ends
        return np.asarray(self.seconds[self.begin[at] + (drawn * self.held[at]).astype(np.int64)])


def best_pooling(task: Task, seen: SeenActions) -> float:
    """Return the weight w of pooled counts in `LearnedOdds` that has the largest likelihood in a
    cross-validation.

    A larger w gives an action's outcomes in all contexts (such as after two Fails) more weight in a rare
    context. The cross-validation is five-fold.
    """
    scores = dict.fromkeys(POOLING_WEIGHTS, 0.0)
    numbers = np.arange(len(seen.success))
    for fold in range(_FOLDS):
        learned = _counts(task, seen.chosen(numbers[numbers % _FOLDS != fold]))
        other = _counts(task, seen.chosen(numbers[numbers % _FOLDS == fold]))
        for pooling in POOLING_WEIGHTS:
            scores[pooling] += float((other * np.log(np.maximum(_shares(learned, pooling), _LEAST))).sum())
    return max(POOLING_WEIGHTS, key=lambda pooling: scores[pooling])


def _counts(task: Task, seen: SeenActions) -> FloatArray:
    """Return the counts (entries, contexts, ends) of the ends seen."""
    shape = (len(task.file.actions), CONTEXT_COUNT, KNOWN_ENDS)
    flat = np.ravel_multi_index((seen.entry, seen.context, seen.end), shape)
    return np.bincount(flat, minlength=int(np.prod(shape))).reshape(shape).astype(np.float64)


def _shares(counts: FloatArray, pooling: float) -> FloatArray:
    """Return probabilities (entries, contexts, ends) that sum to 1 over ends; 0 for an action never
    started.
    """
    every = counts.sum(axis=1, keepdims=True)
    pooled = every / np.maximum(every.sum(axis=2, keepdims=True), 1.0)
    return np.asarray((counts + pooling * pooled) / (counts.sum(axis=2, keepdims=True) + pooling))
