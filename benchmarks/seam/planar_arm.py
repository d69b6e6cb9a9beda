"""An arm of two revolute joints in a plane: figure 1 of Shin (2005)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.arms.score_rule import UNUSABLE_SCORE, ScoreRule, worth
from handcart.robotics.manipulation.arms.two_links import two_links
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled


class PlanarArm(NamedTuple):
    """Two links that turn about the base's position, in the plane z = 0."""

    first: float = 1.0
    """Length a1, in [m]."""
    second: float = 1.0
    """Length a2, in [m]."""
    side: float = 1.0
    """1: the elbow is to the left of the line from base to tool; -1: to the right."""

    def scores(self, bases: FloatArray, path: ToolPath, rule: ScoreRule) -> PlacementScores:
        """Return the scores of base poses (b, 3): x and y in [m], heading in [rad] (ignored by this arm)."""
        values, usable = _table(
            np.ascontiguousarray(bases[:, :2]),
            path.points,
            path.tangents,
            np.array(self),
            int(rule.measure),
            rule.limits,
        )
        return PlacementScores(values.T, usable.T)

    def joints(self, base: FloatArray, points: FloatArray) -> FloatArray:
        """Joint angles (p, 2) in [rad] from a base pose (3,) for points (p, 2 or 3); NaN out of reach.

        They are relative to the axes of the path, whatever the base's heading.
        """
        angles = np.full((len(points), 2), np.nan)
        for row, point in enumerate(points):
            x, y = point[0] - base[0], point[1] - base[1]
            reached, ux, uy, vx, vy, sin = two_links(x, y, self.first, self.second, self.side)
            if reached:
                angles[row] = np.arctan2(uy, ux), np.arctan2(sin, ux * vx + uy * vy)
        return angles

    def jacobian(self, q: FloatArray) -> FloatArray:
        """(..., 2, 2) at angles (..., 2), below figure 2 of Shin (2005)."""
        both = q[..., 0] + q[..., 1]
        x2, y2 = self.second * np.cos(both), self.second * np.sin(both)
        x1, y1 = self.first * np.cos(q[..., 0]), self.first * np.sin(q[..., 0])
        return np.stack((np.stack((-y1 - y2, -y2), -1), np.stack((x1 + x2, x2), -1)), -2)


@compiled
def _table(
    bases: FloatArray,
    points: FloatArray,
    tangents: FloatArray,
    arm: FloatArray,
    measure: int,
    limits: FloatArray,
) -> tuple[SingleArray, BoolArray]:
    first, second, side = arm[0], arm[1], arm[2]
    values = np.zeros((len(points), len(bases)), dtype=np.float32)
    usable = np.zeros((len(points), len(bases)), dtype=np.bool_)
    elements, rates = np.empty(2), np.empty(2)
    for j in range(len(points)):
        kx, ky = tangents[j, 0], tangents[j, 1]
        for b in range(len(bases)):
            x, y = points[j, 0] - bases[b, 0], points[j, 1] - bases[b, 1]
            reached, _, _, vx, vy, sin = two_links(x, y, first, second, side)
            if not reached:
                continue
            elements[0] = abs(ky * x - kx * y)
            elements[1] = abs(second * (ky * vx - kx * vy))
            area = max(first * second * abs(sin), 1e-300)  # |det J|
            rates[0] = abs(second * (kx * vx + ky * vy)) / area
            rates[1] = abs(kx * x + ky * y) / area
            value = worth(measure, elements, rates, area, limits)
            if value != UNUSABLE_SCORE:
                values[j, b] = value
                usable[j, b] = True
    return values, usable
