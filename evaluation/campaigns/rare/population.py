"""Multilevel splitting: a population of runs that is continued from level to level."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from handcart.robotics.numerics.arrays import IndexArray


class Level(NamedTuple):
    """Counts of the runs that started at one level of multilevel splitting, by how these runs ended."""

    runs: int
    reached: int
    """Number of runs that reached the next level, from which they are continued."""
    hits: int
    """Number of runs that ended with the rare outcome before the next level."""
    steps: int
    """Number of actions that the runs started."""


class Runs(Protocol):
    """Interface of runs for multilevel splitting, which can be stopped at a level and continued from it
    several times.

    A level is a number of used attempts, by which a run has come nearer to a rare outcome.
    """

    def advance(self, level: int, starts: IndexArray | int) -> Level:
        """Continue runs until they end or reach a level of multilevel splitting, and keep their states there.

        Args:
            level: importance (nearness to the rare outcome) at which the runs are stopped, from 1.
            starts: (n,) for each run, the index of the state kept at the previous level that it starts from;
                or the number of runs that start from the beginning.
        """


class Population(NamedTuple):
    """Population of runs of multilevel splitting (a method for rare events), as counts of the runs at each
    level.
    """

    levels: tuple[Level, ...]

    @property
    def weights(self) -> tuple[float, ...]:
        """Estimated share of all runs, 0 to 1, that reach each level, which is a stage before the rare
        outcome.
        """
        reached = [level.reached / level.runs for level in self.levels[:-1]]
        return tuple(np.cumprod([1.0, *reached]).tolist())

    @property
    def probability(self) -> float:
        """Unbiased estimate of the probability of the rare outcome, valid with any number of runs.

        It is the sum over all levels of the share of hits among the runs that started at a level, weighted
        with the estimated share of all runs that reach that level (Del Moral, Feynman-Kac Formulae, 2004,
        theorem 7.4.2). It is unbiased for any choice of levels.
        """
        levels = zip(self.weights, self.levels, strict=True)
        return sum(weight * level.hits / level.runs for weight, level in levels)

    @property
    def steps(self) -> int:
        """Number of actions that all runs of the population have started."""
        return sum(level.steps for level in self.levels)

    @property
    def steps_of_a_run(self) -> float:
        """Unbiased estimate of the mean number of actions in a complete run."""
        levels = zip(self.weights, self.levels, strict=True)
        return sum(weight * level.steps / level.runs for weight, level in levels)


def split(runs: Runs, count: int, draws: np.random.Generator) -> Population:
    """Run a population of simulated runs from level to level towards a rare outcome, until no run reaches the
    next level.

    This is multilevel splitting: runs that reach a level are continued several times from there.

    Args:
        runs: runs that have not started.
        count: number of runs at each level.
        draws: random generator for the choice of the continued runs.
    """
    levels: list[Level] = []
    starts: IndexArray | int = count
    while not levels or levels[-1].reached:
        levels.append(runs.advance(len(levels) + 1, starts))
        if levels[-1].reached:
            starts = shared_out(levels[-1].reached, count, draws)
    return Population(tuple(levels))


def shared_out(kinds: int, count: int, draws: np.random.Generator) -> IndexArray:
    """Return indices (count,) below `kinds`, each equally often, the remainder chosen at random.

    Args:
        kinds: number of different indices.
        count: number of indices to return.
        draws: source of the random choice.
    """
    whole = np.repeat(np.arange(kinds), count // kinds)
    rest = draws.permutation(kinds)[: count % kinds]
    return np.concatenate([whole, np.sort(rest)])
