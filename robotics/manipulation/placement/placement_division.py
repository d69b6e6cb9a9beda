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
    """Part of a path that the arm tracks from one pose of the base, its placement.

    The next segment begins at the last point of this segment.
    """

    placement: int
    """Number of the base pose."""
    first: int
    last: int
    """Last point of the segment; `first` and `last` are both included."""


class Division(NamedTuple):
    """Division of a path into segments, each tracked from one base pose, with the integral of the score."""

    segments: tuple[PathSegment, ...]
    score: float
    """Integral of the score along the path, in [m]; at most the path's length for scores up to 1."""


class TooFewPlacements(Untrackable):
    """Error of a path that needs more placements (base poses) than were allowed.

    Attributes:
        needed: smallest number of placements that is enough.
    """

    def __init__(self, index: int, count: int, needed: int) -> None:
        super().__init__(index, f"is as far as {count} placements get; needed: {needed}")
        self.needed = needed


def fewest_placements(scores: PlacementScores) -> int:
    """Return the smallest number of placements (poses of the base) from which the arm tracks the complete
    path.

    Raises:
        Untrackable: no set of placements tracks the complete path; the error names the first point that the
            placements do not track.
    """
    return len(_longest_first(scores))


def best_division(scores: PlacementScores, lengths: FloatArray, count: int) -> Division:
    """Return the division of a path among at most `count` placements with the greatest integral of the score.

    The result is the exact optimum.

    It is computed by layered dynamic programming over the steps j of the path and the placements b: D_k(j, b)
    = gain(b, j) + max(D_k(j-1, b), max over b' of D_{k-1}(j-1, b')). D_k(j, b) is the best integral up to
    step j with k placements, the last of which is b. The integral never falls with more placements, so their
    number must be limited; see also `best_division_by_cost`.

    Among placements of equal value the one with the lowest number is taken, so base poses should be in the
    order of preference.

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
    """Return the division of a path with the greatest integral of the score, less `cost` for each move of the
    base.

    The result is the exact optimum.

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
    """Return the scores of base poses, their masks and the path's steps as contiguous arrays, for compiled
    functions.

    Args:
        scores: scores of b placements of the base at p points of the tool's path.
        lengths: (p,) arc length of the points, in [m].

    Returns:
        Scores (p, b); a mask (p, b), True where the arm reaches the point within the limits of the score; a
            mask (p-1, b), True for steps without a jump of the arm's joints, or an empty array if no step
            needs a jump; and lengths (p-1,) of the steps, in [m].
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
    """Return the error that no base pose lets the arm track both point `index` of a path and the next."""
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
    """Return a path divided into the given segments, each with its base pose, and the integral of the score
    along them, in [m].

    Args:
        segments: parts of the path, in order.
        values: (p, b) scores, from 0 to 1, of each point of the path from each base pose (placement).
        steps: (p-1,) distances of neighbouring points of the path, in [m].
    """
    score = sum(segment_score(values, steps, *segment) for segment in segments)
    return Division(tuple(segments), float(score))
