"""Walks through an action network that are stopped at a level and continued from there."""

from __future__ import annotations

import numpy as np

from handcart.evaluation.campaigns.walks.odds import EndCode
from handcart.evaluation.campaigns.walks.walk_table import GOAL, NO_WAY
from handcart.evaluation.campaigns.walks.walker import GAVE_UP, Stride, Walker
from handcart.networks.graph.network import ActionNetwork
from handcart.robotics.numerics.arrays import BoolArray, IndexArray, Int32Array

from .population import Level
from .rare_event import RareEvent


class WalkedRuns:
    """Random walks through a task's network, which can be stopped when they reach a level of importance (a
    measure of how close a walk is to a rare event), and continued from there.
    """

    def __init__(
        self, network: ActionNetwork, walker: Walker, event: RareEvent, draws: np.random.Generator
    ) -> None:
        """Prepare walks that have not started.

        Args:
            network: the network of the walker.
            walker: walker with the outcome probabilities.
            event: the rare event.
            draws: random generator for the outcomes.
        """
        self._walker, self._event, self._draws = walker, event, draws
        self._attempts = np.array([action.allowance.most for action in network.actions], dtype=np.int32)
        self._at = self._importance = np.zeros(0, dtype=np.int32)
        self._after_fail = self._skipped = np.zeros(0, dtype=bool)

    def advance(self, level: int, starts: IndexArray | int) -> Level:
        """Continue random walks until they end or reach a level of multilevel splitting, and keep their
        states there.

        Args:
            level: importance (nearness to the rare outcome) at which the walks are stopped, from 1.
            starts: (n,) index of the state, kept at the previous level, that each walk starts from; or the
                number of new walks.
        """
        self._begin(starts)
        steps = 0
        while (left := np.flatnonzero((self._at >= 0) & (self._importance < level))).size:
            made = self._walker.stride(
                self._at[left], self._after_fail[left], self._draws.random((2, left.size))
            )
            self._skipped[left] |= made.skip
            self._after_fail[left], self._at[left] = made.after_fail, made.next
            self._importance[left] = self._nearer(self._importance[left], made)
            steps += int((~made.skip).sum())
        reached = self._at >= 0
        found = Level(reached.size, int(reached.sum()), int(self._hits().sum()), steps)
        self._keep(np.flatnonzero(reached))
        return found

    def _begin(self, starts: IndexArray | int) -> None:
        if not isinstance(starts, int):
            self._keep(starts)
            return
        self._at = np.full(starts, self._walker.start, dtype=np.int32)
        self._importance = np.zeros(starts, dtype=np.int32)
        self._after_fail, self._skipped = np.zeros(starts, dtype=bool), np.zeros(starts, dtype=bool)

    def _keep(self, which: IndexArray) -> None:
        self._at, self._importance = self._at[which], self._importance[which]
        self._after_fail, self._skipped = self._after_fail[which], self._skipped[which]

    def _nearer(self, importance: Int32Array, made: Stride) -> Int32Array:
        """Return the importance (n,) of each walk after this action, given that (n,) before it."""
        failed, for_good = made.ends == EndCode.FAIL, made.ends == EndCode.FOR_GOOD
        if self._event.importance == "fails":
            return np.asarray(importance + (failed | for_good), dtype=np.int32)
        used = np.select([failed, for_good], [made.fails + 1, self._attempts[made.action]], 0)
        return np.asarray(np.maximum(importance, used), dtype=np.int32)

    def _hits(self) -> BoolArray:
        """Return a mask (n,) of the walks that have ended with the rare outcome."""
        left_undone = (self._at == GOAL) & self._skipped
        match self._event.outcome:
            case "GiveUp":
                found = self._at == GAVE_UP
            case "Success":
                found = (self._at == GOAL) & ~left_undone
            case _:
                found = (self._at == NO_WAY) | left_undone
        return np.asarray(found)
