"""Placements moved off their grid, to the poses with the best scores."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.numerics.arrays import FloatArray

from .placement_division import Division, PathSegment, best_division

Scorer = Callable[[FloatArray, ToolPath], PlacementScores]
"""Function that returns the scores of base poses along a path; excluded poses are not usable.

Base poses (b, 3) are world_T_base: x, y in [m], heading in [rad].
"""

_TRIES = 48
_SHRINK = 0.5
_ROUNDS = 12
_FINEST = 1e-3  # of the first radius


class Refinement(NamedTuple):
    """Division of a path among base poses that were moved off the search grid to increase the total score."""

    bases: FloatArray
    """(k, 3): one for each segment, x and y in [m], heading in [rad]."""
    division: Division
    """Placement numbers are rows of `bases`."""
    gain: float
    """Increase of the score, in [m]; never below zero."""


def refine(
    scorer: Scorer,
    path: ToolPath,
    bases: FloatArray,
    division: Division,
    radius: float,
    turn: float,
    seed: int = 0,
) -> Refinement:
    """Improve the division of a path into segments, each tracked by the arm from one base pose.

    Each base pose is moved to where its segment's score is best. Then the path is divided again, among the
    old and the moved base poses, and so on. The search ends when a new division does not improve the score:
    at a local optimum, never worse than the start. How far the global optimum may be is not known from this
    search; see `placement_bound`.

    Args:
        scorer: returns the scores of base poses.
        path: path of the tool in the world.
        bases: (b, 3) world_T_base, x, y in [m] and heading in [rad]; the division refers to them by row.
        division: the division to begin with.
        radius: first search distance around a base pose, in [m]: the step of the grid.
        turn: first search angle around a base pose's heading, in [rad]: the step of the grid.
        seed: seed of the search's random poses.
    """
    rng = np.random.default_rng(seed)
    count = len(division.segments)
    start = division.score
    pool = np.array([bases[segment.placement] for segment in division.segments])
    current = _renumbered(division)
    for _ in range(_ROUNDS):
        better = [
            _climb(scorer, path, pool[segment.placement], segment, (radius, turn), rng)
            for segment in current.segments
        ]
        tried = np.vstack((pool, better))
        found = best_division(scorer(tried, path), path.lengths, count)
        if found.score <= current.score + 1e-9 * path.length:
            break
        pool = np.array([tried[segment.placement] for segment in found.segments])
        current = _renumbered(found)
    return Refinement(pool, current, current.score - start)


def _renumbered(division: Division) -> Division:
    segments = (segment._replace(placement=row) for row, segment in enumerate(division.segments))
    return division._replace(segments=tuple(segments))


def _climb(
    scorer: Scorer,
    path: ToolPath,
    base: FloatArray,
    segment: PathSegment,
    reach: tuple[float, float],
    rng: np.random.Generator,
) -> FloatArray:
    """Return the best base pose (3,) of random ones around the best one so far, ever nearer.

    `reach` is the largest step along x and y in [m], and of the heading in [rad], at the beginning.
    """
    part = path.part(segment.first, segment.last)
    best, value = base, _worth(scorer, np.atleast_2d(base), part)[0]
    scale = 1.0
    while scale > _FINEST:
        steps = rng.uniform(-1.0, 1.0, (_TRIES, 3)) * scale * np.array((reach[0], reach[0], reach[1]))
        values = _worth(scorer, best + steps, part)
        top = int(np.argmax(values))
        if values[top] > value:
            best, value = best + steps[top], values[top]
        else:
            scale *= _SHRINK
    return best


def _worth(scorer: Scorer, bases: FloatArray, part: ToolPath) -> FloatArray:
    """Return the integrals (b,) of the scores over a part; -inf if a point of it cannot be tracked."""
    scores = scorer(bases, part)
    sound = scores.usable.all(axis=1)
    if scores.joined is not None:
        sound &= scores.joined.all(axis=1)
    steps = np.diff(part.lengths)
    values = scores.values.astype(np.float64)
    return np.where(sound, 0.5 * (values[:, :-1] + values[:, 1:]) @ steps, -np.inf)
