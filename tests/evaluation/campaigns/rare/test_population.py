"""Populations that are taken on from level to level."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from handcart.evaluation.campaigns.rare.population import Level, Population, shared_out, split
from handcart.robotics.numerics.arrays import IndexArray


class Scripted:
    """Fake runs that reach the given levels and record where they were started."""

    def __init__(self, *levels: tuple[int, int]) -> None:
        self._levels = list(levels)
        self.asked: list[tuple[int, IndexArray | int]] = []

    def advance(self, level: int, starts: IndexArray | int) -> Level:
        self.asked.append((level, starts))
        reached, hits = self._levels.pop(0)
        return Level(8, reached, hits, 10)


def test_what_each_level_shows_is_weighed_with_how_many_come_there() -> None:
    runs = Scripted((4, 1), (2, 2), (0, 4))
    found = split(runs, 8, np.random.default_rng(0))
    assert found.weights == (1.0, 0.5, 0.125)
    assert found.probability == pytest.approx(1 / 8 + 0.5 * 2 / 8 + 0.125 * 4 / 8)
    assert found.steps == 30
    assert found.steps_of_a_run == pytest.approx((1.0 + 0.5 + 0.125) * 10 / 8)
    assert [level for level, _ in runs.asked] == [1, 2, 3]
    assert runs.asked[0][1] == 8
    assert [np.bincount(np.asarray(starts)).tolist() for _, starts in runs.asked[1:]] == [[2] * 4, [4] * 2]


def test_nothing_is_taken_on_where_nothing_came_nearer() -> None:
    assert split(Scripted((0, 0)), 8, np.random.default_rng(0)).probability == 0.0


@pytest.mark.parametrize("kinds", [1, 3, 7, 10])
def test_all_are_taken_on_equally_often(kinds: int) -> None:
    times: Sequence[np.ndarray[tuple[int], np.dtype[np.int64]]] = [
        np.bincount(shared_out(kinds, 10, np.random.default_rng(seed)), minlength=kinds)
        for seed in range(400)
    ]
    assert all(time.sum() == 10 and time.max() - time.min() <= 1 for time in times)
    mean, sigma = 10 / kinds, 0.5 / 400**0.5
    assert np.abs(np.mean(times, axis=0) - mean).max() < 4 * sigma


def test_a_level_that_only_some_reach_still_counts() -> None:
    assert Population((Level(10, 1, 0, 10), Level(10, 0, 10, 10))).probability == pytest.approx(0.1)
