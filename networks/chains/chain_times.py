"""Time of the runs of Markov chains that follow each other: quantiles from seeded walks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.numerics.arrays import FloatArray

from .chain_rows import ChainEnd, ChainRows

WALK_COUNT = 10_000
MAX_WALK_STEPS = 4_000_000
"""Maximum number of actions of all walks together; long runs have fewer walks."""
_GOAL, _ENDED, _LOST = -1, -2, -3


class Quantile(NamedTuple):
    """Lower and upper bound of a quantile of the time of a run, estimated from random walks in a Markov
    chain.

    The bounds are equal unless a walk came to a state that the chain omits.
    """

    low_s: float
    high_s: float


def time_quantile(
    chains: Sequence[ChainRows],
    mean_actions: float,
    share: float = 0.95,
    seed: int = 0,
    calls: bool = False,
) -> Quantile:
    """Estimate the time in [s] within which a share of the runs ends, from seeded random walks.

    With `WALK_COUNT` walks, the share has a standard error of 0.002.

    Args:
        chains: rows of the consecutive parts of a run; each begins where the one before reaches its goal.
        mean_actions: average number of actions of a run.
        share: share of the runs.
        seed: seed of the walks.
        calls: True if a person is called in states missing in `chains`, so that runs end there; False
            if runs may take any time from there, so that the upper bound may be infinite.
    """
    count = int(min(WALK_COUNT, max(100.0, MAX_WALK_STEPS / max(1.0, mean_actions))))
    walks = _Walks(count, np.random.default_rng([23, seed]))
    for rows in chains:
        walks.through(rows)
    spent, lost = walks.spent, walks.lost & (not calls)
    low = float(np.quantile(spent, share))
    high = float(np.quantile(np.where(lost, math.inf, spent), share, method="higher")) if lost.any() else low
    return Quantile(low, high)


class _Walks:
    """Random runs that are drawn in parallel."""

    def __init__(self, count: int, draws: np.random.Generator) -> None:
        self.spent = np.zeros(count)
        self.lost = np.zeros(count, dtype=bool)
        """Walks that came to a state that was not looked at, or took too many steps."""
        self._goes_on = np.ones(count, dtype=bool)
        self._draws, self._left = draws, 4 * MAX_WALK_STEPS
        self._known: dict[int, tuple[FloatArray, NDArray[np.int64], FloatArray]] = {}

    def through(self, rows: ChainRows) -> None:
        """Walk from the start of a chain until each walk has reached its goal or ended."""
        if rows.start < 0:
            return
        if id(rows) not in self._known:
            self._known[id(rows)] = (*_outcomes(rows), rows.cost)
        limits, nexts, cost = self._known[id(rows)]
        walks = np.flatnonzero(self._goes_on)
        at = np.full(walks.size, rows.start)
        while walks.size:
            self._left -= walks.size
            self.spent[walks] += cost[at]
            at = nexts[np.searchsorted(limits, at + self._draws.random(walks.size), side="right")]
            if self._left < 0:
                at[at >= 0] = _LOST
            self._goes_on[walks[(at == _ENDED) | (at == _LOST)]] = False
            self.lost[walks[at == _LOST]] = True
            walks, at = walks[at >= 0], at[at >= 0]


def _outcomes(rows: ChainRows) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return tables from which the row that follows a row is drawn.

    Returns:
        Limits (k,), ascending, of which the first above a random number in [row, row + 1) is chosen; and the
            row (k,) that follows by each, or a negative code of an end.
    """
    after = np.full(len(ChainEnd), _ENDED, np.int64)
    after[[ChainEnd.GOAL, ChainEnd.UNKNOWN]] = _GOAL, _LOST
    links, ends, skipped = rows.succeeds.joined(rows.fails, rows.skips), rows.ends, rows.skipped_to_goal
    row = np.concatenate((links.row, ends.row, skipped))
    to = np.concatenate((links.to, after[ends.end], np.full(len(skipped), _GOAL, np.int64)))
    p = np.concatenate((links.p, ends.p, np.ones(len(skipped))))
    order = np.lexsort((p, to, row))
    row, to, p = row[order], to[order], p[order]
    total = np.cumsum(p)
    first = np.searchsorted(row, np.arange(len(rows.action)))
    before = np.concatenate(([0.0], total))[first]
    limits = np.asarray(row + np.minimum(total - before[row], 1.0), np.float64)
    last = np.append(row[1:] != row[:-1], True)
    limits[last] = row[last] + 1.0
    return limits, to
