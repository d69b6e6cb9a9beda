"""Divisions against exhaustive search, and against the paper's rule."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise, product

import numpy as np
import pytest

from benchmarks.seam.greedy_division import greedy_division
from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.placement_division import (
    TooFewPlacements,
    best_division,
    best_division_by_cost,
    fewest_placements,
)

CASES = 300


def _random(rng: np.random.Generator) -> tuple[PlacementScores, np.ndarray]:
    bases, points = rng.integers(1, 5), rng.integers(2, 8)
    usable = rng.random((bases, points)) < rng.choice([0.5, 0.8, 1.0])
    values = np.where(usable, rng.random((bases, points)), 0.0).astype(np.float32)
    joined = rng.random((bases, points - 1)) < 0.9 if rng.random() < 0.5 else None
    return PlacementScores(values, usable, joined), np.concatenate(([0.0], np.cumsum(rng.random(points - 1))))


def _all_divisions(scores: PlacementScores, lengths: np.ndarray, count: int) -> Iterator[tuple[int, float]]:
    """Number of segments and integral of every division that can be tracked, by brute force."""
    bases, points = scores.usable.shape
    steps, values = np.diff(lengths), scores.values.astype(float)
    for segments in range(1, min(count, points - 1) + 1):
        for cuts in combinations(range(1, points - 1), segments - 1):
            for chosen in product(range(bases), repeat=segments):
                total, sound = 0.0, True
                for base, (a, b) in zip(chosen, pairwise((0, *cuts, points - 1)), strict=True):
                    sound &= bool(scores.usable[base, a : b + 1].all())
                    sound &= scores.joined is None or bool(scores.joined[base, a:b].all())
                    total += float(0.5 * steps[a:b] @ (values[base, a:b] + values[base, a + 1 : b + 1]))
                if sound:
                    yield segments, total


@pytest.mark.slow
def test_equal_to_exhaustive_search_and_never_below_greedy() -> None:
    rng = np.random.default_rng(0)
    tracked = 0
    for _ in range(CASES):
        scores, lengths = _random(rng)
        count, cost = int(rng.integers(1, 5)), float(rng.choice([0.0, 0.05, 0.5]))
        found = list(_all_divisions(scores, lengths, 7))
        some = [total for segments, total in found if segments <= count]
        if some:
            tracked += 1
            assert best_division(scores, lengths, count).score == pytest.approx(max(some), abs=1e-6)
            assert fewest_placements(scores) == min(segments for segments, _ in found)
        elif found:
            with pytest.raises(TooFewPlacements) as few:
                best_division(scores, lengths, count)
            assert few.value.needed == min(segments for segments, _ in found)
        else:
            with pytest.raises(Untrackable):
                best_division(scores, lengths, 7)
            continue
        dear = best_division_by_cost(scores, lengths, cost)
        paid = dear.score - cost * (len(dear.segments) - 1)
        assert paid == pytest.approx(max(total - cost * (n - 1) for n, total in found), abs=1e-6)
        greedy = greedy_division(scores, lengths)
        assert best_division(scores, lengths, len(greedy.segments)).score >= greedy.score - 1e-6
    assert tracked > CASES // 3


def test_segments_join_and_cover_the_path() -> None:
    scores = PlacementScores(np.ones((3, 6), np.float32), np.tri(3, 6, 3, dtype=bool))
    division = best_division(scores, np.arange(6.0), 3)
    assert division.segments[0].first == 0
    assert division.segments[-1].last == 5
    assert all(a.last == b.first for a, b in pairwise(division.segments))
    assert division.score == pytest.approx(5.0)


def test_weights_are_lengths_not_numbers_of_points() -> None:
    values = np.array([[1.0, 1.0, 0.2, 0.2], [0.4, 0.4, 0.6, 0.6]], np.float32)
    scores = PlacementScores(values, np.ones((2, 4), bool))
    assert best_division(scores, np.array([0.0, 0.1, 0.2, 5.0]), 1).segments[0].placement == 1
    assert best_division(scores, np.array([0.0, 4.8, 4.9, 5.0]), 1).segments[0].placement == 0


def test_what_is_blocked_is_divided_again() -> None:
    rng = np.random.default_rng(3)
    scores = PlacementScores(rng.random((6, 30)).astype(np.float32), np.ones((6, 30), bool))
    first = best_division(scores, np.arange(30.0), 2)
    blocked = np.zeros(6, bool)
    blocked[first.segments[0].placement] = True
    again = best_division(scores.without(blocked), np.arange(30.0), 2)
    assert all(not blocked[segment.placement] for segment in again.segments)
    assert again.score <= first.score


def test_a_point_out_of_everybodys_reach_is_named() -> None:
    usable = np.ones((2, 5), bool)
    usable[:, 3] = False
    with pytest.raises(Untrackable, match="point 3 of the path can't be tracked from any"):
        best_division(PlacementScores(usable.astype(np.float32), usable), np.arange(5.0), 5)
    with pytest.raises(Untrackable, match=r"point 2 of the path .* also tracks the point before"):
        usable = np.array([[True, True, False, False], [False, False, True, True]])
        best_division(PlacementScores(usable.astype(np.float32), usable), np.arange(4.0), 5)


def test_of_equals_the_first_is_taken() -> None:
    """Base poses are ordered by preference."""
    values = np.full((4, 6), 0.5, dtype=np.float32)
    values[0, 0] = 0.0
    usable = np.ones((4, 6), dtype=np.bool_)
    usable[0, 0] = False
    scores, lengths = PlacementScores(values, usable), np.arange(6.0)
    assert best_division(scores, lengths, 1).segments == ((1, 0, 5),)
    assert best_division_by_cost(scores, lengths, 0.1).segments == ((1, 0, 5),)
    assert greedy_division(scores, lengths).segments == ((1, 0, 5),)
