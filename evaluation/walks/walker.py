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


class Walker:
    """Walks as the coordinator would, with odds for what happens."""

    def __init__(self, table: WalkTable, odds: Odds) -> None:
        """In a network's table, which others may walk in, too."""
        self._table, self._odds = table, odds

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
            columns = self._table.columns()
            moment = at[left]
            action, skip = columns.action[moment], columns.skip[moment]
            context = context_of(columns.fails[moment], after_fail[left])
            ends = np.where(skip, End.SUCCESS, self._odds.ends(action, context, drawn[0])).astype(np.int8)
            seconds = np.where(skip, 0.0, self._odds.seconds(action, context, ends, drawn[1]))
            skipped[left] |= skip
            after_fail[left] = np.where(skip, after_fail[left], ends != End.SUCCESS)
            at[left] = self._next(moment, ends)
            where[left] = self._where(moment, ends, at[left])
            rows.append(_row(count, left, np.where(skip, NOTHING, action), ends, seconds))
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
