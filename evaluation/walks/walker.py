"""Walks through a network, many side by side."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .odds import Codes, End, Floats, Numbers, Odds, context_of
from .walk_table import GOAL, NO_WAY, WalkTable

PERSON = -3
"""In place of a moment's number: a walk ended with a GiveUp."""
NOTHING = -1
"""In place of an action: the walk was over, or left an element undone."""


class Walked(NamedTuple):
    """What was walked: `steps` rows, a column for each of n walks."""

    action: Numbers
    """(steps, n) by their numbers in the network; or `NOTHING`."""
    ends: Codes
    """(steps, n)."""
    seconds: Floats
    """(steps, n)."""
    skipped: NDArray[np.bool_]
    """(n,) whether an element of a repeat was left undone."""
    last: Numbers
    """(n,) `GOAL`, `NO_WAY` or `PERSON`."""
    where: Numbers
    """(n,) a number for where it ended: walks that have `last`, `skipped` and this in common ended alike."""

    @property
    def success(self) -> NDArray[np.bool_]:
        """(n,) whether each reached the goal with nothing left undone."""
        return np.asarray((self.last == GOAL) & ~self.skipped)


class Stride(NamedTuple):
    """What n walks do next, (n,) each."""

    action: Numbers
    fails: Numbers
    """How often it has failed before."""
    skip: NDArray[np.bool_]
    """Whether it only leaves an element of a repeat undone."""
    ends: Codes
    seconds: Floats
    after_fail: NDArray[np.bool_]
    """Whether the last action that was no skip has failed."""
    next: Numbers
    """The moment that follows; `GOAL`, `NO_WAY` or `PERSON`."""


class Walker:
    """Walks as the coordinator would, with odds for what happens."""

    def __init__(self, table: WalkTable, odds: Odds) -> None:
        """In a network's table, which others may walk in, too."""
        self._table, self._odds = table, odds

    @property
    def start(self) -> int:
        """The moment at which each walk begins; `GOAL` or `NO_WAY` where it doesn't."""
        return int(self._table.start)

    def walk(self, draws: np.random.Generator, count: int) -> Walked:
        """Walk to all ends.

        Args:
            draws: what is drawn; the same gives the same walks.
            count: how many, n.
        """
        at = np.full(count, self._table.start, dtype=np.int32)
        after_fail, skipped = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        where = np.zeros(count, dtype=np.int32)
        rows: list[tuple[Numbers, Codes, Floats]] = []
        while (left := np.flatnonzero(at >= 0)).size:
            drawn = draws.random((2, count))[:, left]
            moment = at[left]
            made = self.stride(moment, after_fail[left], drawn)
            skipped[left] |= made.skip
            after_fail[left], at[left] = made.after_fail, made.next
            where[left] = self._where(moment, made.ends, made.next)
            rows.append(_row(count, left, np.where(made.skip, NOTHING, made.action), made.ends, made.seconds))
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

    def stride(self, moment: Numbers, after_fail: NDArray[np.bool_], drawn: Floats) -> Stride:
        """Take walks on by an action each.

        Args:
            moment: where they are (n,), by the table's numbers.
            after_fail: whether the action before has failed (n,).
            drawn: evenly from 0 to 1 (2, n).
        """
        columns = self._table.columns()
        action, skip, fails = columns.action[moment], columns.skip[moment], columns.fails[moment]
        context = context_of(fails, after_fail)
        ends = np.where(skip, End.SUCCESS, self._odds.ends(action, context, drawn[0])).astype(np.int8)
        seconds = np.where(skip, 0.0, self._odds.seconds(action, context, ends, drawn[1]))
        after = np.where(skip, after_fail, ends != End.SUCCESS)
        return Stride(action, fails, skip, ends, seconds, after, self._next(moment, ends))

    def _next(self, moment: Numbers, ends: Codes) -> Numbers:
        columns = self._table.columns()
        following = np.where(ends == End.SUCCESS, columns.next[moment], PERSON).astype(np.int32)
        for end, states in ((End.FAIL, columns.after_fail), (End.FOR_GOOD, columns.for_good)):
            failed = ends == end
            following[failed] = self._table.first(states[moment[failed]])
        return following

    def _where(self, moment: Numbers, ends: Codes, following: Numbers) -> Numbers:
        columns = self._table.columns()
        state = np.where(ends == End.FOR_GOOD, columns.for_good[moment], columns.after_fail[moment])
        person = moment * len(End) + ends
        return np.select([following == NO_WAY, following == PERSON], [state, person], 0).astype(np.int32)


def _row(
    count: int, left: NDArray[np.intp], action: Numbers, ends: Codes, seconds: Floats
) -> tuple[Numbers, Codes, Floats]:
    """Of all walks, those that are over included."""
    actions, codes = np.full(count, NOTHING, dtype=np.int32), np.zeros(count, dtype=np.int8)
    times = np.zeros(count)
    actions[left], codes[left], times[left] = action, ends, seconds
    return actions, codes, times
