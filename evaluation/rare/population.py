"""Multilevel splitting: a population of runs that is taken on from level to level."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.intp]


class Level(NamedTuple):
    """What became of the runs that began at a level."""

    runs: int
    reached: int
    """Those that came to the next level, and are taken on from there."""
    hits: int
    """Those that ended as is asked for without coming there."""
    steps: int
    """Actions that they started."""


class Runs(Protocol):
    """Runs that can be stopped where they reach a level, and taken on from there, again and again."""

    def advance(self, level: int, starts: Numbers | int) -> Level:
        """Take runs on until they end or reach a level, and keep where they reach it.

        Args:
            level: the importance at which they are stopped, from 1.
            starts: which of those that reached the level before each begins with, by their numbers in the
                order in which they were kept; how many, where they begin at the beginning.
        """


class Population(NamedTuple):
    """Levels, from the beginning to the last that a run has reached."""

    levels: tuple[Level, ...]

    @property
    def weights(self) -> tuple[float, ...]:
        """The share of all runs that come to each level, as these runs show it."""
        reached = [level.reached / level.runs for level in self.levels[:-1]]
        return tuple(np.cumprod([1.0, *reached]).tolist())

    @property
    def probability(self) -> float:
        """How often a run ends as is asked for. Unbiased, however few the runs are.

        Given where the runs before have reached a level, each of the next ones begins there as any run that
        comes to it does, and what it shows is weighed with what is known of how many come (Del Moral,
        Feynman-Kac Formulae, 2004, theorem 7.4.2). Where levels lie doesn't matter for that.
        """
        levels = zip(self.weights, self.levels, strict=True)
        return sum(weight * level.hits / level.runs for weight, level in levels)

    @property
    def steps(self) -> int:
        """Actions that were started."""
        return sum(level.steps for level in self.levels)

    @property
    def steps_of_a_run(self) -> float:
        """Actions that a run starts on average from its beginning to its end; unbiased as well."""
        levels = zip(self.weights, self.levels, strict=True)
        return sum(weight * level.steps / level.runs for weight, level in levels)


def split(runs: Runs, count: int, draws: np.random.Generator) -> Population:
    """Take a population on from level to level until no run reaches another one.

    Args:
        runs: new ones.
        count: how many there are at each level.
        draws: decide which of them are taken on.
    """
    levels: list[Level] = []
    starts: Numbers | int = count
    while not levels or levels[-1].reached:
        levels.append(runs.advance(len(levels) + 1, starts))
        if levels[-1].reached:
            starts = shared_out(levels[-1].reached, count, draws)
    return Population(tuple(levels))


def shared_out(kinds: int, count: int, draws: np.random.Generator) -> Numbers:
    """Which of some kinds each of `count` gets (count,): all equally often, and by lot where they can't."""
    whole = np.repeat(np.arange(kinds), count // kinds)
    rest = draws.permutation(kinds)[: count % kinds]
    return np.concatenate([whole, np.sort(rest)])
