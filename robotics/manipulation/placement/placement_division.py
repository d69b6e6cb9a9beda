"""A path divided among base placements, and how divisions are found."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.paths.untrackable import Untrackable

from .division_programs import cheapest_layers, farthest_run, heaviest_run, layers, segment_score

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Masks = NDArray[np.bool_]


class PathSegment(NamedTuple):
    """Part of the path that is tracked from one placement. The next segment begins at this one's last
    point.
    """

    placement: int
    """Number of the base pose."""
    first: int
    last: int
    """Points of the path, both included."""


class Division(NamedTuple):
    """Segments in the order of the path."""

    segments: tuple[PathSegment, ...]
    score: float
    """Integral of the score along the path, in [m]; at most the path's length for scores up to 1."""


class TooFewPlacements(Untrackable):
    """More placements are needed than were allowed.

    Attributes:
        needed: the fewest that do.
    """

    def __init__(self, index: int, count: int, needed: int) -> None:
        super().__init__(index, f"is as far as {count} placements get; needed: {needed}")
        self.needed = needed


def fewest_placements(scores: PlacementScores) -> int:
    """The smallest number of placements that track the whole path.

    Raises:
        Untrackable: none does; the first bad point is named.
    """
    return len(_longest_first(scores))


def best_division(scores: PlacementScores, lengths: Floats, count: int) -> Division:
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
    return _division(layers(*_arrays(scores, lengths), count), scores, lengths)


def best_division_by_cost(scores: PlacementScores, lengths: Floats, cost: float) -> Division:
    """The division with the greatest integral less `cost`, in [m], for each move of the base: exact.

    Raises:
        Untrackable: no set of placements tracks the path.
    """
    _longest_first(scores)
    return _division(cheapest_layers(*_arrays(scores, lengths), cost), scores, lengths)


def greedy_division(scores: PlacementScores, lengths: Floats) -> Division:
    """Divide by the paper's rule: take the placement with the greatest integral on the remaining path, and
    repeat.

    The paper doesn't define the ends of a segment. Here it begins at the end of the one before, and ends
    where the placement becomes unusable.

    Raises:
        Untrackable: no placement continues from some point.
    """
    values, usable, joined, steps = _arrays(scores, lengths)
    first, segments = 0, []
    while first < len(steps):
        placement, last = heaviest_run(values, usable, joined, steps, first)
        if last <= first:
            raise _stuck(scores, first)
        segments.append(PathSegment(int(placement), first, int(last)))
        first = int(last)
    return _total(segments, values, steps)


def division_by_hand(
    scores: PlacementScores, lengths: Floats, placements: Sequence[int], cuts: Sequence[int]
) -> Division:
    """Return a division chosen by the caller: `cuts` are the points between one placement and the next.

    Raises:
        Untrackable: a placement can't track its part; the first bad point is named.
        ValueError: cuts that don't grow, or not one fewer than placements.
    """
    values, usable, joined, steps = _arrays(scores, lengths)
    ends = [0, *cuts, len(steps)]
    if len(ends) != len(placements) + 1 or any(a >= b for a, b in pairwise(ends)):
        needed = len(placements) - 1
        raise ValueError(f"{len(placements)} placements need {needed} growing cuts inside the path")
    segments = [
        PathSegment(placement, *between)
        for placement, between in zip(placements, pairwise(ends), strict=True)
    ]
    for number, (placement, first, last) in enumerate(segments):
        bad = np.flatnonzero(~usable[first : last + 1, placement])
        if len(bad):
            why = f"can't be tracked from placement {number} of the division"
            raise Untrackable(first + int(bad[0]), why)
        if joined.size and not joined[first:last, placement].all():
            index = first + 1 + int(np.argmin(joined[first:last, placement]))
            raise Untrackable(index, f"makes the arm jump at placement {number} of the division")
    return _total(segments, values, steps)


def _arrays(scores: PlacementScores, lengths: Floats) -> tuple[Singles, Masks, Masks, Floats]:
    """(p, b) values and usable, (p-1, b) joined (or empty), (p-1,) lengths of steps."""
    joined = np.zeros((0, 0), dtype=np.bool_) if scores.joined is None else scores.joined.T
    return (
        np.ascontiguousarray(scores.values.T),
        np.ascontiguousarray(scores.usable.T),
        np.ascontiguousarray(joined),
        np.diff(lengths),
    )


def _longest_first(scores: PlacementScores) -> list[PathSegment]:
    """Divide by longest segments: no division has fewer, because a part of a usable run is usable."""
    _, usable, joined, steps = _arrays(scores, np.arange(scores.usable.shape[1], dtype=np.float64))
    scores.check()
    first, segments = 0, []
    while first < len(steps):
        placement, last = farthest_run(usable, joined, first)
        if last <= first:
            raise _stuck(scores, first)
        segments.append(PathSegment(int(placement), first, int(last)))
        first = int(last)
    return segments


def _stuck(scores: PlacementScores, index: int) -> Untrackable:
    scores.check()
    return Untrackable(index + 1, "can't be tracked from a placement that also tracks the point before it")


def _division(placements: NDArray[np.int64], scores: PlacementScores, lengths: Floats) -> Division:
    """Build the division from the placement of each step (p-1,)."""
    starts = np.flatnonzero(np.concatenate(([True], placements[1:] != placements[:-1])))
    ends = np.append(starts[1:], len(placements))
    segments = [PathSegment(int(placements[a]), int(a), int(b)) for a, b in zip(starts, ends, strict=True)]
    values, _, _, steps = _arrays(scores, lengths)
    return _total(segments, values, steps)


def _total(segments: Sequence[PathSegment], values: Singles, steps: Floats) -> Division:
    score = sum(segment_score(values, steps, *segment) for segment in segments)
    return Division(tuple(segments), float(score))
