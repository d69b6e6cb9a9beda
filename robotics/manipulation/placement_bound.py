"""What no placement can be worth more than: a proven bound for arms in closed form.

A score is bounded over all shoulders in a disc at once, by intervals of the distances and angles in it. Among
discs that cover where shoulders may stand, the exact division of these bounds is at least as good as that of
any placements anywhere, so the gap between it and a division found is proven. Yaw limits and the azimuth
tolerance are left out, which only raises the bound. It falls to the true score as the discs shrink.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robotics.navigation.compiled import compiled

from .pitch_arm import PitchArm
from .placement_division import best_division
from .placement_scores import PlacementScores
from .planar_arm import PlanarArm
from .score_rule import Measure, ScoreRule
from .tool_path import ToolPath

Floats = NDArray[np.float64]


def score_bound(
    arm: PlanarArm | PitchArm,
    path: ToolPath,
    rule: ScoreRule,
    corner: Floats,
    size: Floats,
    step: float,
    count: int,
) -> float:
    """The most that any division among at most `count` placements is worth, in [m]: proven.

    Args:
        corner, size: (2,) of the rectangle in which shoulders may stand, in [m]. The shoulder of a planar arm
            is its base; that of a pitch arm is its yaw axis.
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
    values, usable = _upper_table(
        centres, radius, _marks(arm, path), _figures(arm), rule.measure == Measure.SURE, rule.low, rule.high
    )
    return best_division(PlacementScores(values.T, usable.T), path.lengths, count).score


def _marks(arm: PlanarArm | PitchArm, path: ToolPath) -> Floats:
    """(p, 9): position, tangent; the tool's level and upright parts, and its rate of elevation."""
    if isinstance(arm, PlanarArm):
        flat = np.zeros((len(path.points), 9))
        flat[:, :2], flat[:, 3:5] = path.points[:, :2], path.tangents[:, :2]
        return flat
    return arm.marks(path)[:, [0, 1, 2, 3, 4, 5, 8, 9, 10]]


def _figures(arm: PlanarArm | PitchArm) -> Floats:
    """Height, three links, and the number of joints: two in the plane of the floor, or yaw and pitches."""
    if isinstance(arm, PlanarArm):
        return np.array((0.0, arm.first, arm.second, 0.0, 2.0))
    return np.array((arm.height, *arm.links, 4.0))


@compiled
def _largest_area(nearest: float, farthest: float, first: float, second: float) -> float:
    """Of |first x second| over wrist distances in an interval: a growing, then falling function of them."""
    peak = math.sqrt(first * first + second * second)
    at = min(max(peak, nearest), farthest)
    cos = (at * at - first * first - second * second) / (2.0 * first * second)
    return first * second * math.sqrt(max(0.0, 1.0 - cos * cos))


@compiled
def _least_product(a: float, a_slack: float, b: float, b_slack: float, more: float) -> float:
    """Least |a b + more| over intervals of a and b about their middles."""
    low, high = np.inf, -np.inf
    for i in (-1.0, 1.0):
        for j in (-1.0, 1.0):
            product = (a + i * a_slack) * (b + j * b_slack) + more
            low, high = min(low, product), max(high, product)
    if low <= 0.0 <= high:
        return 0.0
    return min(abs(low), abs(high))


@compiled
def _upper_table(
    centres: Floats, radius: float, marks: Floats, arm: Floats, sure: bool, low: Floats, high: Floats
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    height, l1, l2, l3, joints = arm[0], arm[1], arm[2], arm[3], int(arm[4])
    whole = l1 + l2 + l3
    values = np.zeros((len(marks), len(centres)), dtype=np.float32)
    usable = np.zeros((len(marks), len(centres)), dtype=np.bool_)
    for j in range(len(marks)):
        kx, ky, kz = marks[j, 3], marks[j, 4], marks[j, 5]
        cos, sin, rate = marks[j, 6], marks[j, 7], marks[j, 8]
        tip_z = marks[j, 2] - height
        wrist_z = tip_z - l3 * sin
        level = math.hypot(kx, ky)
        for b in range(len(centres)):
            x, y = marks[j, 0] - centres[b, 0], marks[j, 1] - centres[b, 1]
            distance = math.hypot(x, y)
            near, far = max(distance - radius, 0.0), distance + radius
            wrist_near, wrist_far = near - l3 * cos, far - l3 * cos
            least_wrist = 0.0 if wrist_near <= 0.0 <= wrist_far else min(abs(wrist_near), abs(wrist_far))
            most_wrist = max(abs(wrist_near), abs(wrist_far))
            nearest, farthest = math.hypot(least_wrist, wrist_z), math.hypot(most_wrist, wrist_z)
            if nearest > l1 + l2 or farthest < abs(l1 - l2):
                continue
            turned = abs(ky * x - kx * y)
            least_turned = max(turned - level * radius, 0.0)
            most = max(turned + level * radius, whole if joints > 2 else l2)
            value = min(1.0, (high[0] - least_turned) / (0.5 * (high[0] - low[0])))
            fastest = -np.inf
            for i in range(joints):
                fastest = max(fastest, (most - low[i]) / (0.5 * (high[i] - low[i])))
            value = min(value, fastest)
            area = max(_largest_area(nearest, farthest, l1, l2), 1e-300)
            if joints == 2:
                along = max(abs(kx * x + ky * y) - level * radius, 0.0)
                if sure:
                    value = min(value, 1.0 - low[1] * along / area)
            elif near > 0.0:
                towards = (kx * x + ky * y) / distance
                slack = level * radius / near
                lever = abs(kz * distance - towards * tip_z) - abs(kz) * radius - slack * abs(tip_z)
                value = min(value, (high[1] - max(lever, 0.0)) / (0.5 * (high[1] - low[1])))
                if sure:
                    value = min(value, 1.0 - low[0] * least_turned / (far * far))
                    upright = (kz - rate * l3 * cos) * wrist_z
                    bend = _least_product(
                        towards + rate * l3 * sin, slack, distance - l3 * cos, radius, upright
                    )
                    value = min(value, 1.0 - low[2] * bend / area)
            if value > 0.0:
                values[j, b] = np.float32(value * (1.0 + 1e-6))
                usable[j, b] = True
    return values, usable
