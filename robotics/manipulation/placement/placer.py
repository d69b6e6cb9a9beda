"""Division of a path among base placements, with any arm."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IndexArray

from .base_scorer import BaseScorer, path_points
from .placement_division import Division, PathSegment, best_division, fewest_placements
from .placement_refinement import Scorer, refine
from .placements import Placements
from .untrackable_reason import explained

Blocked = Callable[[FloatArray], BoolArray]
"""Function that returns a mask (b,) of the base poses that the base can't occupy, or doesn't reach.

Base poses (b, 3) are world_T_base: x, y in [m], heading in [rad].
"""
Free = Callable[[FloatArray, FloatArray], bool]
"""Function that returns True if nothing is touched from a base pose (3,) at joint angles (p, n) in [rad].

The base pose is world_T_base: x, y in [m], heading in [rad].
"""

_ATTEMPTS = 20  # at a division all of whose parts the arm follows, point by point
_MORE = 8  # placements than there must be, that are tried
_HALVINGS = 2  # of the coarse grid, around the places found on it


class Placer(BaseScorer):
    """Planner that divides a path among base poses (placements) from which an arm follows the parts.

    The best division is found exactly on a grid of base poses, which are then moved to the best score nearby.

    An arm with closed-form inverse kinematics (`PitchArm`) is tried from about 20,000 base poses, any other
    arm from about 2000, at fewer points of the path. Every part of a division is then followed point by
    point; a base pose from which the arm does not follow is excluded, and the search begins again.
    """

    def place(
        self,
        path: ToolPath,
        blocked: Blocked,
        count: int | None = None,
        free: Free | None = None,
        cost: float = 0.0,
    ) -> Placements:
        """Return the division of a path among base poses that has the best score; each part is tracked from
        one pose.

        Args:
            path: path of the tool.
            blocked: function that reports which of many base poses are blocked.
            count: maximum number of placements; None: as few as possible.
            free: function that reports whether the robot touches nothing at a chosen placement, given the
                joint angles along its part of the path.
            cost: score that one more placement must gain, in [m].

        Raises:
            Untrackable: no set of placements tracks the path, or more than `count` are needed; the error
                names the path's first point that cannot be tracked, and the nearest position that can, if
                known.
        """
        kept = _thinned(len(path.points), self.grid.points)
        thin = path_points(path, kept)
        candidates = self.candidates(path)
        bases = candidates[~blocked(candidates)]
        left_out: list[FloatArray] = []

        def scorer(some: FloatArray, part: ToolPath) -> PlacementScores:
            out = blocked(some)
            for array in left_out:
                out |= _near(some, array, 0.5 * self.step)
            return self.robust_scores(some, part).without(out)

        scores = self.robust_scores(bases, thin)
        for _ in range(_ATTEMPTS):
            try:
                division = _worthwhile(scores, thin, count, cost)
            except Untrackable as error:
                raise explained(self, error, scorer, thin, (bases, candidates), kept) from None
            chosen, refined = self._refined(scorer, thin, bases, division)
            placements = self._placements(chosen, _on(refined, kept), path)
            bad = self._not_followed(placements, path, free)
            if not bad:
                return placements
            for base in placements.bases[list(bad)]:
                left_out.append(base)
                scores = scores.without(_near(bases, base, 0.5 * self.step))
        last = min(bad.values(), key=lambda untrackable: untrackable.index)
        raise Untrackable(last.index, f"{last.why}; so it was with {_ATTEMPTS} divisions")

    def _refined(
        self, scorer: Scorer, path: ToolPath, bases: FloatArray, division: Division
    ) -> tuple[FloatArray, Division]:
        """Return base poses (k, 3) and the division among them, each moved to where it is worth more."""
        step, turn, count = self.step, 2 * np.pi / self.grid.headings, len(division.segments)
        if self.pitch_arm is not None:
            found = refine(scorer, path, bases, division, step, turn)
            return found.bases, found.division
        chosen = np.array([bases[segment.placement] for segment in division.segments])
        for _ in range(_HALVINGS):
            step, turn = step / 2, turn / 2
            tried = np.vstack((chosen, _neighbours(chosen, step, turn)))
            best = best_division(scorer(tried, path), path.lengths, count)
            chosen = np.array([tried[segment.placement] for segment in best.segments])
        renumbered = (segment._replace(placement=row) for row, segment in enumerate(best.segments))
        return chosen, best._replace(segments=tuple(renumbered))

    def _placements(self, bases: FloatArray, segments: tuple[PathSegment, ...], path: ToolPath) -> Placements:
        """Return the placements with the scores of their segments on the path's own points."""
        found = []
        for segment in segments:
            part = path.part(segment.first, segment.last)
            values = self.scores(bases[segment.placement][None], part).values[0].astype(np.float64)
            found.append(float(np.trapezoid(values, part.lengths)))
        return Placements(bases, segments, tuple(found))

    def _not_followed(
        self, placements: Placements, path: ToolPath, free: Free | None
    ) -> dict[int, Untrackable]:
        """Return errors by the row of each base pose from which the arm does not follow its segment."""
        found = dict[int, Untrackable]()
        for segment in placements.segments:
            base, part = placements.bases[segment.placement], path.part(segment.first, segment.last)
            try:
                angles = self.followed(base, part)
            except Untrackable as error:
                found[segment.placement] = Untrackable(segment.first + error.index, error.why)
                continue
            if free is not None and not free(base, angles):
                touches = "or those after it can only be tracked with the robot touching something"
                found[segment.placement] = Untrackable(segment.first, touches)
        return found


def _worthwhile(scores: PlacementScores, path: ToolPath, count: int | None, cost: float) -> Division:
    """Return the division with the greatest score less `cost` for each placement; raises as
    `best_division`.
    """
    fewest = fewest_placements(scores)
    most = fewest if count is None else count
    if most <= fewest or cost == 0.0:
        return best_division(scores, path.lengths, most)
    numbers = range(fewest, min(most, fewest + _MORE) + 1)
    divisions = (best_division(scores, path.lengths, number) for number in numbers)
    return max(divisions, key=lambda division: division.score - cost * len(division.segments))


def _near(bases: FloatArray, base: FloatArray, distance: float) -> BoolArray:
    """Return (b,) True for base poses (b, 3) within `distance` in [m] of another (3,)."""
    return np.asarray(np.linalg.norm(bases[:, :2] - base[:2], axis=1) < distance)


def _neighbours(bases: FloatArray, step: float, turn: float) -> FloatArray:
    """(26 b, 3): base poses one step to all sides of base poses (b, 3)."""
    ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    return np.asarray((bases[:, None] + ways * (step, step, turn)).reshape(-1, 3))


def _thinned(points: int, most: int) -> IndexArray:
    """Return the indices (k,) of at most `most` points, evenly chosen, both ends included."""
    return np.unique(np.linspace(0, points - 1, min(points, most)).round().astype(np.intp))


def _on(division: Division, kept: IndexArray) -> tuple[PathSegment, ...]:
    """Return the segments of a division of thinned points, in indices of the path's own points."""
    return tuple(
        PathSegment(part.placement, int(kept[part.first]), int(kept[part.last])) for part in division.segments
    )
