"""A path divided among base placements, and how divisions are found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray

from .division_programs import cheapest_layers, farthest_run, layers, segment_score


class PathSegment(NamedTuple):
    """Part of the path that is tracked from one placement. The next segment begins at this one's last
    point.
    """

    placement: int
    """Number of the base pose."""
    first: int
    last: int
    """Last point of the segment; `first` and `last` are both included."""


class Division(NamedTuple):
    """Segments in the order of the path."""

    segments: tuple[PathSegment, ...]
    score: float
    """Integral of the score along the path, in [m]; at most the path's length for scores up to 1."""


class TooFewPlacements(Untrackable):
    """Error of a path that needs more placements than were allowed.

    Attributes:
        needed: smallest number of placements that is enough.
    """

    def __init__(self, index: int, count: int, needed: int) -> None:
        super().__init__(index, f"is as far as {count} placements get; needed: {needed}")
        self.needed = needed


def fewest_placements(scores: PlacementScores) -> int:
    """Return the smallest number of placements that track the whole path.

    Raises:
        Untrackable: no set of placements does; the first bad point is named.
    """
    return len(_longest_first(scores))


def best_division(scores: PlacementScores, lengths: FloatArray, count: int) -> Division:
    """Return the division among at most `count` placements with the greatest integral: exact.

    By layered dynamic programming over the steps j of the path and the placements b: D_k(j, b) = gain(b,
    j) + max(D_k(j-1, b), max over b' of D_{k-1}(j-1, b')). The integral never falls with more placements,
    so their number must be given; see `best_division_by_cost`.

    Among equals the placement with the lowest number is taken: order base poses by preference.

    Args:
        scores: scores of the placements.
        lengths: arc length of the points (p,), in [m].
        count: maximum number of placements.

    Raises:
        Untrackable: no set of placements tracks the path.
        TooFewPlacements: `count` placements are not enough.
    """
    needed = _longest_first(scores)
    if count < len(needed):
        reached = needed[count - 1].last if count > 0 else 0
        raise TooFewPlacements(reached, count, len(needed))
    return _division(layers(*score_arrays(scores, lengths), count), scores, lengths)


def best_division_by_cost(scores: PlacementScores, lengths: FloatArray, cost: float) -> Division:
    """Return the division with the greatest integral less `cost` for each move of the base: exact.

    Args:
        scores: scores of the placements.
        lengths: (p,) arc length of the points, in [m].
        cost: price of a move of the base, in [m].

    Raises:
        Untrackable: no set of placements tracks the path.
    """
    _longest_first(scores)
    return _division(cheapest_layers(*score_arrays(scores, lengths), cost), scores, lengths)


def score_arrays(
    scores: PlacementScores, lengths: FloatArray
) -> tuple[SingleArray, BoolArray, BoolArray, FloatArray]:
    """Return the contiguous arrays of scores that compiled functions take.

    Args:
        scores: scores of the placements.
        lengths: (p,) arc length of the points, in [m].

    Returns:
        Scores (p, b) and where they are usable (p, b), joined steps (p-1, b) or an empty array, and lengths
        of the steps (p-1,) in [m].
    """
    joined = np.zeros((0, 0), dtype=np.bool_) if scores.joined is None else scores.joined.T
    return (
        np.ascontiguousarray(scores.values.T),
        np.ascontiguousarray(scores.usable.T),
        np.ascontiguousarray(joined),
        np.diff(lengths),
    )


def _longest_first(scores: PlacementScores) -> list[PathSegment]:
    """Divide by longest segments: no division has fewer, because a part of a usable run is usable."""
    _, usable, joined, steps = score_arrays(scores, np.arange(scores.usable.shape[1], dtype=np.float64))
    scores.check()
    first, segments = 0, []
    while first < len(steps):
        placement, last = farthest_run(usable, joined, first)
        if last <= first:
            raise stuck_at(scores, first)
        segments.append(PathSegment(int(placement), first, int(last)))
        first = int(last)
    return segments


def stuck_at(scores: PlacementScores, index: int) -> Untrackable:
    """Return the error for a point from which no placement continues."""
    scores.check()
    return Untrackable(index + 1, "can't be tracked from a placement that also tracks the point before it")


def _division(placements: IntArray, scores: PlacementScores, lengths: FloatArray) -> Division:
    """Build the division from the placement of each step (p-1,)."""
    starts = np.flatnonzero(np.concatenate(([True], placements[1:] != placements[:-1])))
    ends = np.append(starts[1:], len(placements))
    segments = [PathSegment(int(placements[a]), int(a), int(b)) for a, b in zip(starts, ends, strict=True)]
    values, _, _, steps = score_arrays(scores, lengths)
    return score_segments(segments, values, steps)


def score_segments(segments: Sequence[PathSegment], values: SingleArray, steps: FloatArray) -> Division:
    """Return the division into the given segments, with its integral in [m].

    Args:
        segments: parts of the path, in order.
        values: (p, b) scores of points from placements, from 0 to 1.
        steps: (p-1,) lengths of the steps, in [m].
    """
    score = sum(segment_score(values, steps, *segment) for segment in segments)
    return Division(tuple(segments), float(score))
