"""Scores of base poses for an arm that works along a path, and the arm's motion from one of them."""

from __future__ import annotations

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

from .placements import Work

_SPARE = 0.08  # [rad] before a joint's limit, for a base that stops elsewhere
_STOPS = 0.025  # [m] by which a base may stop beside its place, and the arm must still do it
_BESIDE = ((_STOPS, 0.0), (-_STOPS, 0.0), (0.0, _STOPS), (0.0, -_STOPS))
_SPARSE = 4  # points of a path between those looked at then


class _Grid(NamedTuple):
    """Density of the base poses that are tried."""

    step: float
    """Distance between base poses, in [m]."""
    headings: int
    points: int
    """Maximum number of points of the path."""
    bases: int
    """Maximum number of base poses; the step grows until the grid has no more."""


FINE_GRID = _Grid(0.1, 20, 400, 60_000)  # for the closed form: 0.1 us a cell
COARSE_GRID = _Grid(0.2, 6, 100, 2500)  # for any arm: tens of us


class BaseScorer:
    """Scorer of how well one arm can do its work along a path from each pose of the base.

    It also returns the arm's joints along the path from a base pose. Scores are computed by a `Measure`. By
    default this is eq. 6 of Shin (2005) together with the exact condition for the joints' speed.

    Raises:
        ValueError: a joint of the arm slides, or has no lever (distance of the tool from its axis) at which
            it is both fast and strong enough.
    """

    def __init__(self, arm: ArmModel, work: Work, measure: Measure = Measure.SURE) -> None:
        self.arm = arm
        self.follower = ToolFollower(arm, work.free, work.azimuth_tolerance)
        self.pitch_arm = pitch_arm_of(arm, work.azimuth_tolerance) if work.free == FreeTurn.VERTICAL else None
        self._screw_arm = ScrewArm(arm, work.free, work.azimuth_tolerance)
        chain = self._screw_arm.chain
        self._screw_arm.chain = chain._replace(lower=chain.lower + _SPARE, upper=chain.upper - _SPARE)
        self.grid = COARSE_GRID if self.pitch_arm is None else FINE_GRID
        self.step = self.grid.step
        joints = arm.dof if self.pitch_arm is None else 4
        torque = ArmLoad(arm).torque[:joints]
        self.rule = ScoreRule.of_limits(measure, arm.velocity[:joints], torque, work.speed, work.force)
        self.work = work

    def scores(self, bases: FloatArray, path: ToolPath) -> PlacementScores:
        """Return scores, from 0 to 1, of how well the arm can work at each point of a path from each base
        pose.

        Args:
            bases: (b, 3) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool in the world.
        """
        return self.scores_by(bases, path, self.rule)

    def reached(self, bases: FloatArray, path: ToolPath) -> BoolArray:
        """Return a mask (b, p), True for points of a path that the arm reaches from a base pose; limits of
        joint speeds are not considered.

        Args:
            bases: (b, 3) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool in the world.
        """
        return self.scores_by(bases, path, self.rule._replace(measure=Measure.REACHABILITY)).usable

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance between neighbouring base poses in the latest grid of `candidates`, in [m], and between
        headings, in [rad].
        """
        return self.step, 2.0 * np.pi / self.grid.headings

    def scores_by(self, bases: FloatArray, path: ToolPath, rule: ScoreRule) -> PlacementScores:
        """Return the scores of a path's points from base poses, by `rule` instead of the scorer's own rule.

        Args:
            bases: (b, 3) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool in the world.
            rule: rule for the score: its measure, and the limits of the joints.
        """
        if self.pitch_arm is not None:
            return self.pitch_arm.scores(bases, path, rule)
        return self._screw_arm.scores(bases, path, rule)

    def robust_scores(self, bases: FloatArray, path: ToolPath) -> PlacementScores:
        """Return the scores of a path's points from base poses, robust against small errors of the base's
        pose.

        A point is usable from a base pose only if the arm reaches it from neighbouring base poses as well.

        For an arm with closed-form inverse kinematics the scores are unchanged, because neighbours are
        checked later for the few chosen base poses.

        Args:
            bases: (b, 3) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool in the world.
        """
        scores = self.scores(bases, path)
        if self.pitch_arm is not None or not len(bases):
            return scores
        reach = self.rule._replace(measure=Measure.REACHABILITY)
        usable, some = scores.usable.copy(), scores.usable.any(axis=1)
        for x, y in _BESIDE:
            usable[some] &= self.scores_by(bases[some] + (x, y, 0.0), path, reach).usable
            some &= usable.any(axis=1)
        return scores.restricted(usable)

    def joints(self, base: FloatArray, path: ToolPath) -> FloatArray:
        """Return joint angles (p, n), in [rad], that follow a path from a base pose.

        Args:
            base: (3,) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool in the world.

        Raises:
            Untrackable: the arm does not reach all points; the error has the index of the first such point.
        """
        world_T_base = Pose2(*base.tolist()).lift()
        if self.pitch_arm is not None:
            near = np.append(self.pitch_arm.joints(base, path)[0], 0.0)
            if np.isnan(near).any():
                raise Untrackable(0, "can't be reached from the base's pose")
            return self.follower.joints(path, world_T_base, near)
        first, count = None, len(path.points)
        near_all = self._screw_arm.joints(base, path, self.rule)
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
        on = self.follower.joints(path_points(path, np.arange(start, len(path.points))), world_T_base, near)
        try:
            back = self.follower.joints(path_points(path, np.arange(start, -1, -1)), world_T_base, on[0])
        except Untrackable as error:
            raise Untrackable(start - error.index, error.why, error.nearest) from None
        return np.vstack((back[:0:-1], on))

    def candidates(self, path: ToolPath) -> FloatArray:
        """Return a grid of base poses around a path, within the arm's reach of it.

        Args:
            path: path of the tool in the world.

        Returns:
            (b, 3) world_T_base: x, y in [m], heading in [rad].
        """
        self.step = self.grid.step
        spots = self._spots(path, self.step)
        while len(spots) * self.grid.headings > self.grid.bases:
            self.step *= 1.1
            spots = self._spots(path, self.step)
        headings = np.linspace(-np.pi, np.pi, self.grid.headings, endpoint=False)
        turned = np.tile(headings, len(spots))[:, None]
        return np.hstack((np.repeat(spots, len(headings), axis=0), turned))

    @property
    def reach(self) -> float:
        """Upper bound of the tool's horizontal distance from the base's origin, in [m]."""
        return float(self._screw_arm.chain.reach + np.hypot(*self._screw_arm.chain.points[0, :2]))

    def followed(self, base: FloatArray, path: ToolPath) -> FloatArray:
        """Return joint angles (p, n), in [rad], at the p points of a path; check that the arm also reaches
        the path from base poses a few millimetres away from `base`.

        Args:
            base: (3,) world_T_base: x, y in [m], heading in [rad].
            path: path of the tool in the world.

        Raises:
            Untrackable: the arm can't follow the path from `base`, or from one of the poses a few millimetres
                away.
        """
        angles = self.joints(base, path)
        self._check_around(base, path)
        return angles

    def _spots(self, path: ToolPath, step: float) -> FloatArray:
        """(s, 2): x and y of a grid in the world, in [m]."""
        reach = self.reach
        low, high = path.points[:, :2].min(axis=0) - reach, path.points[:, :2].max(axis=0) + reach
        xs, ys = (np.arange(a, b, step) for a, b in zip(low, high, strict=True))
        spots = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
        some = path.points[:: max(1, len(path.points) // 50), :2]
        near = np.linalg.norm(spots[:, None] - some[None], axis=2).min(axis=1) < reach
        return np.asarray(spots[near])

    def _check_around(self, base: FloatArray, path: ToolPath) -> None:
        """Raise Untrackable where the arm doesn't follow from a base that stops a little beside its place."""
        some = path_points(path, np.arange(0, len(path.points), _SPARSE))
        for x, y in _BESIDE:
            try:
                self.joints(np.array(Pose2(*base.tolist()).compose(Pose2(x, y, 0.0))), some)
            except Untrackable as error:
                why = f"{error.why}, {1e3 * _STOPS:g} mm beside its place"
                raise Untrackable(_SPARSE * error.index, why) from None


def path_points(path: ToolPath, kept: IndexArray) -> ToolPath:
    """Return the path with only the points whose indices are in `kept` (k,), in that order."""
    return ToolPath(*(field[kept] for field in path))
