"""Division of a path among base placements, with any arm."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.arms.pitch_arm_of import pitch_arm_of
from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.arms.score_rule import Measure, ScoreRule
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn, ScrewArm
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.tracking.tool_follower import ToolFollower
from handcart.robotics.manipulation.tracking.tracking_limits import ArmLoad
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IndexArray

from .nearest_reachable import with_nearest
from .placement_division import Division, PathSegment, best_division, fewest_placements
from .placement_refinement import Scorer, refine

Blocked = Callable[[FloatArray], BoolArray]
"""Check that marks the base poses (b, 3) that the base can't occupy, or doesn't reach."""
Free = Callable[[FloatArray, FloatArray], bool]
"""Check that nothing is touched from a base pose (3,) at joint angles (p, n)."""

_ATTEMPTS = 20  # at a division all of whose parts the arm follows, point by point
_SPARE = 0.08  # [rad] before a joint's limit, for a base that stops elsewhere
_STOPS = 0.025  # [m] by which a base may stop beside its place, and the arm must still do it
_BESIDE = ((_STOPS, 0.0), (-_STOPS, 0.0), (0.0, _STOPS), (0.0, -_STOPS))
_SPARSE = 4  # points of a path between those looked at then
_MORE = 8  # placements than there must be, that are tried
_FEW = 60  # base poses that a nearest reachable point is looked for from


class Work(NamedTuple):
    """Speed, force and tolerances of a tool along a path."""

    speed: float
    """[m/s]"""
    force: float
    """Along the path, at most, in [N]."""
    free: FreeTurn
    azimuth_tolerance: float
    """Azimuth tolerance used with FreeTurn.VERTICAL, in [rad]."""


class Placements(NamedTuple):
    """A path divided among places."""

    bases: FloatArray
    """(k, 3): x and y in [m], heading in [rad]; one for each segment."""
    segments: tuple[PathSegment, ...]
    """Their numbers are those of the path's points, placements those of `bases`."""
    scores: tuple[float, ...]
    """Integral along each segment, in [m]: up to its length."""

    @property
    def score(self) -> float:
        """Score of the complete path, in [m]."""
        return sum(self.scores)


class _Grid(NamedTuple):
    """Density of the base poses that are tried."""

    step: float
    """[m]"""
    headings: int
    points: int
    """Maximum number of points of the path."""
    bases: int
    """At most, about: where more would be tried, the step grows."""


FINE_GRID = _Grid(0.1, 20, 400, 60_000)  # for the closed form: 0.1 us a cell
COARSE_GRID = _Grid(0.2, 6, 100, 2500)  # for any arm: tens of us
_HALVINGS = 2  # of the coarse grid, around the places found on it


class Placer:
    """Finds placements for one arm and its work: exact on a grid, then each moved to its best score nearby.

    Scores are the sure ones: eq. 6 of Shin (2005), and the exact condition for speed. An arm with a closed
    form (`PitchArm`) is tried from about 20,000 base poses, any other from about 2000, on fewer points.
    Every part of a division is then followed point by point; a base from which that fails is excluded, and
    the search begins again.

    Raises:
        ValueError: a joint of the arm slides, or has no lever that is fast and strong enough.
    """

    def __init__(self, arm: ArmModel, work: Work, measure: Measure = Measure.SURE) -> None:
        self.arm = arm
        self.follower = ToolFollower(arm, work.free, work.azimuth_tolerance)
        self.pitch_arm = pitch_arm_of(arm, work.azimuth_tolerance) if work.free == FreeTurn.VERTICAL else None
        self._screw_arm = ScrewArm(arm, work.free, work.azimuth_tolerance)
        chain = self._screw_arm.chain
        self._screw_arm.chain = chain._replace(lower=chain.lower + _SPARE, upper=chain.upper - _SPARE)
        self._grid = COARSE_GRID if self.pitch_arm is None else FINE_GRID
        self._step = self._grid.step
        joints = arm.dof if self.pitch_arm is None else 4
        torque = ArmLoad(arm).torque[:joints]
        self._rule = ScoreRule.of_limits(measure, arm.velocity[:joints], torque, work.speed, work.force)
        self._work = work

    def scores(self, bases: FloatArray, path: ToolPath) -> PlacementScores:
        """Return the scores of base poses (b, 3)."""
        return self._scores(bases, path, self._rule)

    def reached(self, bases: FloatArray, path: ToolPath) -> BoolArray:
        """Return a mask (b, p): which points of a path the arm reaches from base poses, however slowly.

        Args:
            bases: (b, 3) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool.
        """
        return self._scores(bases, path, self._rule._replace(measure=Measure.REACHABILITY)).usable

    @property
    def spacing(self) -> tuple[float, float]:
        """Spacing of the `candidates` in [m], and of their headings in [rad]."""
        return self._step, 2.0 * np.pi / self._grid.headings

    def _scores(self, bases: FloatArray, path: ToolPath, rule: ScoreRule) -> PlacementScores:
        if self.pitch_arm is not None:
            return self.pitch_arm.scores(bases, path, rule)
        return self._screw_arm.scores(bases, path, rule)

    def _robust(self, bases: FloatArray, path: ToolPath) -> PlacementScores:
        """Return the scores, with only those cells usable that are reached from neighbouring stops of the
        base as well.

        Scores of an arm with a closed form are unchanged: there only the few chosen placements are
        checked.
        """
        scores = self.scores(bases, path)
        if self.pitch_arm is not None or not len(bases):
            return scores
        reach = self._rule._replace(measure=Measure.REACHABILITY)
        usable, some = scores.usable.copy(), scores.usable.any(axis=1)
        for x, y in _BESIDE:
            usable[some] &= self._scores(bases[some] + (x, y, 0.0), path, reach).usable
            some &= usable.any(axis=1)
        return scores.restricted(usable)

    def joints(self, base: FloatArray, path: ToolPath) -> FloatArray:
        """Joint angles (p, n) in [rad] from a base pose (3,); raises Untrackable at the first bad point."""
        world_T_base = Pose2(*base.tolist()).lift()
        if self.pitch_arm is not None:
            near = np.append(self.pitch_arm.joints(base, path)[0], 0.0)
            if np.isnan(near).any():
                raise Untrackable(0, "can't be reached from the base's pose")
            return self.follower.joints(path, world_T_base, near)
        first, count = None, len(path.points)
        near_all = self._screw_arm.joints(base, path, self._rule)
        for start in dict.fromkeys((0, count - 1, count // 2, count // 4, 3 * count // 4)):
            if np.isnan(near_all[start]).any():
                first = first or Untrackable(start, "can't be reached from the base's pose")
                continue
            try:
                return self._both_ways(path, world_T_base, start, near_all[start])
            except Untrackable as error:
                first = first or error
        assert first is not None
        raise first

    def _both_ways(self, path: ToolPath, world_T_base: Transform, start: int, near: FloatArray) -> FloatArray:
        """Joint angles (p, n) found from one of the path's points on, to its end and to its beginning."""
        on = self.follower.joints(_some(path, np.arange(start, len(path.points))), world_T_base, near)
        try:
            back = self.follower.joints(_some(path, np.arange(start, -1, -1)), world_T_base, on[0])
        except Untrackable as error:
            raise Untrackable(start - error.index, error.why, error.nearest) from None
        return np.vstack((back[:0:-1], on))

    def candidates(self, path: ToolPath) -> FloatArray:
        """Return a grid of base poses (b, 3), x, y in [m] and heading in [rad], around a path, within the
        arm's reach of it.
        """
        spots = self._spots(path, self._step)
        while len(spots) * self._grid.headings > self._grid.bases:
            self._step *= 1.1
            spots = self._spots(path, self._step)
        headings = np.linspace(-np.pi, np.pi, self._grid.headings, endpoint=False)
        turned = np.tile(headings, len(spots))[:, None]
        return np.hstack((np.repeat(spots, len(headings), axis=0), turned))

    @property
    def reach(self) -> float:
        """No tool is farther from the base's origin, seen from above, in [m]."""
        return float(self._screw_arm.chain.reach + np.hypot(*self._screw_arm.chain.points[0, :2]))

    def followed(self, base: FloatArray, path: ToolPath) -> FloatArray:
        """Return the joints (p, n) along a path as `joints` does; raise if poses slightly off the placement
        don't follow.

        Args:
            base: (3,) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool.

        Raises:
            Untrackable: the arm can't follow the path from this base, or from slightly beside it.
        """
        angles = self.joints(base, path)
        self._check_around(base, path)
        return angles

    def _spots(self, path: ToolPath, step: float) -> FloatArray:
        """(s, 2): x and y of a grid."""
        reach = self.reach
        low, high = path.points[:, :2].min(axis=0) - reach, path.points[:, :2].max(axis=0) + reach
        xs, ys = (np.arange(a, b, step) for a, b in zip(low, high, strict=True))
        spots = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
        some = path.points[:: max(1, len(path.points) // 50), :2]
        near = np.linalg.norm(spots[:, None] - some[None], axis=2).min(axis=1) < reach
        return np.asarray(spots[near])

    def place(
        self,
        path: ToolPath,
        blocked: Blocked,
        count: int | None = None,
        free: Free | None = None,
        cost: float = 0.0,
    ) -> Placements:
        """Return the best division of a path.

        Args:
            path: path of the tool.
            blocked: check of many base poses.
            count: maximum number of placements; None: as few as possible.
            free: check of the chosen ones, with the angles along their part.
            cost: score that one more placement must gain, in [m].

        Raises:
            Untrackable: no set of placements tracks the path, with the first bad point and the nearest
                that
                can be reached; or more than `count` are needed.
        """
        kept = _thinned(len(path.points), self._grid.points)
        thin = _some(path, kept)
        candidates = self.candidates(path)
        bases = candidates[~blocked(candidates)]
        left_out: list[FloatArray] = []

        def scorer(some: FloatArray, part: ToolPath) -> PlacementScores:
            out = blocked(some)
            for each in left_out:
                out |= _near(some, each, 0.5 * self._step)
            return self._robust(some, part).without(out)

        scores = self._robust(bases, thin)
        for _ in range(_ATTEMPTS):
            try:
                division = _worthwhile(scores, thin, count, cost)
            except Untrackable as error:
                raise self._explained(error, scorer, thin, bases, candidates, kept) from None
            chosen, refined = self._refined(scorer, thin, bases, division)
            placements = self._placements(chosen, _on(refined, kept), path)
            bad = self._not_followed(placements, path, free)
            if not bad:
                return placements
            for base in placements.bases[list(bad)]:
                left_out.append(base)
                scores = scores.without(_near(bases, base, 0.5 * self._step))
        last = min(bad.values(), key=lambda each: each.index)
        raise Untrackable(last.index, f"{last.why}; so it was with {_ATTEMPTS} divisions")

    def _refined(
        self, scorer: Scorer, path: ToolPath, bases: FloatArray, division: Division
    ) -> tuple[FloatArray, Division]:
        """Return base poses (k, 3) and the division among them, each moved to where it is worth more."""
        step, turn, count = self._step, 2 * np.pi / self._grid.headings, len(division.segments)
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
        """With the scores of the segments on the path's own points."""
        found = []
        for segment in segments:
            part = path.part(segment.first, segment.last)
            values = self.scores(bases[segment.placement][None], part).values[0].astype(np.float64)
            found.append(float(np.trapezoid(values, part.lengths)))
        return Placements(bases, segments, tuple(found))

    def _not_followed(
        self, placements: Placements, path: ToolPath, free: Free | None
    ) -> dict[int, Untrackable]:
        """Rows of the base poses from which the arm doesn't follow its part, and why."""
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

    def _check_around(self, base: FloatArray, path: ToolPath) -> None:
        """Raise Untrackable where the arm doesn't follow from a base that stops a little beside its place."""
        some = _some(path, np.arange(0, len(path.points), _SPARSE))
        for x, y in _BESIDE:
            try:
                self.joints(np.array(Pose2(*base.tolist()).compose(Pose2(x, y, 0.0))), some)
            except Untrackable as error:
                why = f"{error.why}, {1e3 * _STOPS:g} mm beside its place"
                raise Untrackable(_SPARSE * error.index, why) from None

    def _explained(
        self,
        error: Untrackable,
        scorer: Scorer,
        thin: ToolPath,
        bases: FloatArray,
        candidates: FloatArray,
        kept: IndexArray,
    ) -> Untrackable:
        """Return the error with the path's own point, the reason, and the nearest position that can be
        tracked.

        `bases` are those of the `candidates` that the base can reach.
        """
        if hasattr(error, "needed"):
            error.index = int(kept[error.index])
            return error
        point = thin.points[error.index]
        nearest = np.argsort(np.linalg.norm(bases[:, :2] - point[:2], axis=1))[: 20 * _FEW]
        few = (
            bases[nearest] if self.pitch_arm is not None else bases[nearest[:: max(1, len(nearest) // _FEW)]]
        )
        detailed = with_nearest(error, scorer, thin, few) if len(few) else error
        why = self._why(_some(thin, np.array([error.index, error.index])), bases, candidates) or error.why
        return Untrackable(int(kept[error.index]), why, detailed.nearest)

    def _why(self, point: ToolPath, bases: FloatArray, candidates: FloatArray) -> str:
        """Why a point, given twice, can't be tracked from any base pose; nothing where it isn't the point."""
        reach = self._rule._replace(measure=Measure.REACHABILITY)
        if not self._scores(candidates, point, reach).usable.any():
            return "is out of the arm's reach, wherever the base stands"
        if not len(bases) or not self._scores(bases, point, reach).usable.any():
            return "is reached only from where the base can't stand, or doesn't get to"
        if not self.scores(bases, point).usable.any():
            work = self._work
            return f"is reached, but nowhere with {work.speed:g} m/s and {work.force:g} N along the path"
        return ""


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
    return max(divisions, key=lambda each: each.score - cost * len(each.segments))


def _near(bases: FloatArray, base: FloatArray, distance: float) -> BoolArray:
    """Return (b,) True for base poses (b, 3) within `distance` of another (3,)."""
    return np.asarray(np.linalg.norm(bases[:, :2] - base[:2], axis=1) < distance)


def _neighbours(bases: FloatArray, step: float, turn: float) -> FloatArray:
    """(26 b, 3): base poses one step to all sides of base poses (b, 3)."""
    ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    return np.asarray((bases[:, None] + ways * (step, step, turn)).reshape(-1, 3))


def _thinned(points: int, most: int) -> IndexArray:
    """Numbers of at most that many of the points, ends included."""
    return np.unique(np.linspace(0, points - 1, min(points, most)).round().astype(np.intp))


def _some(path: ToolPath, kept: IndexArray) -> ToolPath:
    return ToolPath(*(field[kept] for field in path))


def _on(division: Division, kept: IndexArray) -> tuple[PathSegment, ...]:
    """Segments by the numbers of the path's own points."""
    return tuple(
        PathSegment(part.placement, int(kept[part.first]), int(kept[part.last])) for part in division.segments
    )
