"""The reason why a point of a path cannot be tracked from any base pose, in words."""

from __future__ import annotations

import numpy as np

from handcart.robotics.manipulation.arms.score_rule import Measure
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import FloatArray, IndexArray

from .base_scorer import BaseScorer, path_points
from .nearest_reachable import with_nearest
from .placement_division import TooFewPlacements
from .placement_refinement import Scorer

_FEW = 60  # base poses that a nearest reachable point is looked for from


def explained(
    arm: BaseScorer,
    error: Untrackable,
    scorer: Scorer,
    thin: ToolPath,
    poses: tuple[FloatArray, FloatArray],
    kept: IndexArray,
) -> Untrackable:
    """Return an error of a search for base poses, with the reason and the nearest trackable position added.

    The search uses a thinned path; the point in the returned error is that of the complete path.

    Args:
        arm: scorer of base poses for the arm and its work.
        error: error of the search, with the index of a point of the thinned path.
        scorer: function by which the search scored base poses.
        thin: the thinned path, in the world.
        poses: base poses (b, 3) that the base can reach, and all candidates (c, 3), both world_T_base: x, y
            in [m], heading in [rad].
        kept: (p,) index of each point of the thinned path in the complete path.
    """
    bases, candidates = poses
    if isinstance(error, TooFewPlacements):
        error.index = int(kept[error.index])
        return error
    point = thin.points[error.index]
    nearest = np.argsort(np.linalg.norm(bases[:, :2] - point[:2], axis=1))[: 20 * _FEW]
    few = bases[nearest] if arm.pitch_arm is not None else bases[nearest[:: max(1, len(nearest) // _FEW)]]
    detailed = with_nearest(error, scorer, thin, few) if len(few) else error
    twice = path_points(thin, np.array([error.index, error.index]))
    why = _reason(arm, twice, bases, candidates) or error.why
    return Untrackable(int(kept[error.index]), why, detailed.nearest)


def _reason(arm: BaseScorer, point: ToolPath, bases: FloatArray, candidates: FloatArray) -> str:
    """Return why a point cannot be tracked from any base pose; empty if it can be, by itself.

    `point` is a path that consists of the same point twice.
    """
    reach = arm.rule._replace(measure=Measure.REACHABILITY)
    if not arm.scores_by(candidates, point, reach).usable.any():
        return "is out of the arm's reach, wherever the base stands"
    if not len(bases) or not arm.scores_by(bases, point, reach).usable.any():
        return "is reached only from where the base can't stand, or doesn't get to"
    if not arm.scores(bases, point).usable.any():
        speed, force = arm.work.speed, arm.work.force
        return f"is reached, but nowhere with {speed:g} m/s and {force:g} N along the path"
    return ""
