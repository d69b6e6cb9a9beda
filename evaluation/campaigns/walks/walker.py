"""Walker that takes many walks through a network in parallel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IndexArray, Int8Array, Int32Array

from .odds import EndCode, Odds, context_of
from .walk_table import GOAL, NO_WAY, WalkTable

GAVE_UP = -3
"""Value instead of a state's number if the walk ended with a GiveUp."""
NO_ACTION = -1
"""Value instead of an action's index if the walk was over, or skipped an element."""


class Walked(NamedTuple):
    """Record of n walks, which are runs simulated by the network's probabilities alone.

    Row i of an array (steps, n) holds action i of each walk.
    """

    action: Int32Array
    """(steps, n) indices of the actions in the network, or `NO_ACTION`."""
    ends: Int8Array
    """(steps, n) ends of the actions, as `EndCode`."""
    seconds: FloatArray
    """(steps, n) durations of the actions, in [s]."""
    skipped: BoolArray
    """(n,) whether an element of a repeat was skipped."""
    last: Int32Array
    """(n,) end of each walk: `GOAL`, `NO_WAY` or `GAVE_UP`."""
    where: Int32Array
    """(n,) number of the place where each walk ended; walks with equal `last`, `skipped` and `where` ended
    alike.
    """

    @property
    def success(self) -> BoolArray:
        """Mask (n,) of the random walks that reached the goal without skipping an element of a repeated part
        of the task.
        """
        return np.asarray((self.last == GOAL) & ~self.skipped)


class Stride(NamedTuple):
    """Next action of each of n random walks through a network, with its outcome, duration and next state.

    All arrays are (n,).
    """

    action: Int32Array
    fails: Int32Array
    """Number of earlier Fails of the action."""
    skip: BoolArray
    """True if the action only skips an element of a repeat."""
    ends: Int8Array
    seconds: FloatArray
    after_fail: BoolArray
    """True if the last action that was not a skip has failed."""
    next: Int32Array
    """Number of the next state, or `GOAL`, `NO_WAY` or `GAVE_UP`."""


class Walker:
    """Simulator of random walks through a network, with the coordinator's choice of each action."""

    def __init__(self, table: WalkTable, odds: Odds) -> None:
        """Walk in a network's table, which several walkers may share."""
        self._table, self._odds = table, odds

    @property
    def start(self) -> int:
        """Number of the state in which each random walk starts, in the table of a run's states.

        It is `GOAL` or `NO_WAY` if no walk is possible.
        """
        return int(self._table.start)

    def walk(self, draws: np.random.Generator, count: int) -> Walked:
        """Simulate random walks until all have ended, and return their actions, outcomes and durations.

        Args:
            draws: random generator; the same generator state gives the same walks.
            count: number of walks, n.
        """
        at = np.full(count, self._table.start, dtype=np.int32)
        after_fail, skipped = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        where = np.zeros(count, dtype=np.int32)
        rows: list[tuple[Int32Array, Int8Array, FloatArray]] = []
        while (left := np.flatnonzero(at >= 0)).size:
            drawn = draws.random((2, count))[:, left]
            moment = at[left]
            made = self.stride(moment, after_fail[left], drawn)
            skipped[left] |= made.skip
            after_fail[left], at[left] = made.after_fail, made.next
            where[left] = self._where(moment, made.ends, made.next)
            rows.append(
                _row(count, left, np.where(made.skip, NO_ACTION, made.action), made.ends, made.seconds)
            )
        actions, codes, times = zip(*rows, strict=True) if rows else ((), (), ())
        shape = (len(rows), count)
        return Walked(
            np.array(actions, dtype=np.int32).reshape(shape),
            np.array(codes, dtype=np.int8).reshape(shape),
            np.array(times, dtype=np.float64).reshape(shape),
            skipped,
            at,
            where,
        )

    def stride(self, moment: Int32Array, after_fail: BoolArray, drawn: FloatArray) -> Stride:
        """Draw the outcome and duration of each walk's next action; return them with the walks' next states.

        Args:
            moment: (n,) numbers of the walks' present states in the table of states.
            after_fail: (n,) whether the preceding action has failed.
            drawn: (2, n) random numbers, uniform in [0, 1).
        """
        columns = self._table.columns()
        action, skip, fails = columns.action[moment], columns.skip[moment], columns.fails[moment]
        context = context_of(fails, after_fail)
        ends = np.where(skip, EndCode.SUCCESS, self._odds.ends(action, context, drawn[0])).astype(np.int8)
        seconds = np.where(skip, 0.0, self._odds.seconds(action, context, ends, drawn[1]))
        after = np.where(skip, after_fail, ends != EndCode.SUCCESS)
        return Stride(action, fails, skip, ends, seconds, after, self._next(moment, ends))

    def _next(self, moment: Int32Array, ends: Int8Array) -> Int32Array:
        columns = self._table.columns()
        following = np.full(len(moment), GAVE_UP, dtype=np.int32)
        for end, states in (
            (EndCode.SUCCESS, columns.next),
            (EndCode.FAIL, columns.after_fail),
            (EndCode.FOR_GOOD, columns.for_good),
        ):
            failed = ends == end
            following[failed] = self._table.first(states[moment[failed]])
        return following

    def _where(self, moment: Int32Array, ends: Int8Array, following: Int32Array) -> Int32Array:
        columns = self._table.columns()
        state = np.where(ends == EndCode.FOR_GOOD, columns.for_good[moment], columns.after_fail[moment])
        person = moment * len(EndCode) + ends
        return np.select([following == NO_WAY, following == GAVE_UP], [state, person], 0).astype(np.int32)


def _row(
    count: int, left: IndexArray, action: Int32Array, ends: Int8Array, seconds: FloatArray
) -> tuple[Int32Array, Int8Array, FloatArray]:
    """Return actions, ends and seconds of a step for all walks, each (count,).

    Args:
        count: number of all walks.
        left: (k,) indices of the walks that are not over.
        action: (k,) their actions.
        ends: (k,) ends of these actions.
        seconds: (k,) durations, in [s].
    """
    actions, codes = np.full(count, NO_ACTION, dtype=np.int32), np.zeros(count, dtype=np.int8)
    times = np.zeros(count)
    actions[left], codes[left], times[left] = action, ends, seconds
    return actions, codes, times
