"""Upper bound of the score of all placements, proven for arms in closed form.

A score is bounded over all shoulders in a disc at once, by intervals of the distances and angles in it.
Among discs that cover all positions of shoulders, the exact division of these bounds is at least as good
as that of any placements anywhere, so the gap between it and a division found is proven. Yaw limits and
the azimuth tolerance are ignored, which only raises the bound. It falls to the true score as the discs
shrink.
"""

from __future__ import annotations

import math

import numpy as np

from benchmarks.seam.bound_table import bound_table
from benchmarks.seam.planar_arm import PlanarArm
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.arms.score_rule import Measure, ScoreRule
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.placement.placement_division import best_division
from handcart.robotics.numerics.arrays import FloatArray


def score_bound(
    arm: PlanarArm | PitchArm,
    path: ToolPath,
    rule: ScoreRule,
    corner: FloatArray,
    size: FloatArray,
    step: float,
    count: int,
) -> float:
    """Return a proven upper bound of the score of any division among at most `count` placements, in [m].

    Args:
        arm: an arm in closed form.
        path: path of the tool.
        rule: measure and limits.
        corner: (2,) lower corner of the rectangle that holds the shoulders, in [m]. The shoulder of a planar
            arm is its base; that of a pitch arm is its yaw axis.
        size: (2,) sides of the rectangle, in [m].
        count: maximum number of placements.
        step: distance of the discs that cover it, in [m].

    Raises:
        ValueError: the measure is not DIRECTIONAL or SURE.
        Untrackable: some point can't be tracked from anywhere: proven too.
    """
    if rule.measure not in (Measure.DIRECTIONAL, Measure.SURE):
        raise ValueError(f"no bound is known for {rule.measure.name}; allowed: DIRECTIONAL, SURE")
    columns, rows = (max(1, math.ceil(length / step)) for length in size)
    x = corner[0] + size[0] * (np.arange(columns) + 0.5) / columns
    y = corner[1] + size[1] * (np.arange(rows) + 0.5) / rows
    centres = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    radius = 0.5 * float(np.hypot(size[0] / columns, size[1] / rows))
    values, usable = bound_table(
        centres, radius, _marks(arm, path), _figures(arm), rule.measure == Measure.SURE, rule.low, rule.high
    )
    return best_division(PlacementScores(values.T, usable.T), path.lengths, count).score


def _marks(arm: PlanarArm | PitchArm, path: ToolPath) -> FloatArray:
    """(p, 9): position, tangent; the tool's level and upright parts, and its rate of elevation."""
    if isinstance(arm, PlanarArm):
        flat = np.zeros((len(path.points), 9))
        flat[:, :2], flat[:, 3:5] = path.points[:, :2], path.tangents[:, :2]
        return flat
    return arm.marks(path)[:, [0, 1, 2, 3, 4, 5, 8, 9, 10]]


def _figures(arm: PlanarArm | PitchArm) -> FloatArray:
    """Height, three links, the number of joints, and the elbow's side."""
    if isinstance(arm, PlanarArm):
        return np.array((0.0, arm.first, arm.second, 0.0, 2.0, arm.side))
    return np.array((arm.height, *arm.links, 4.0, 1.0))
