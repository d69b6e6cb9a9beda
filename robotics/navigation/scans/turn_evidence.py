"""Share of a scan's information about the heading that does not come from the raster of the map.

On a round wall the cells of the map form a staircase, as along a straight wall that is not parallel to the
axes. Its slopes claim to determine the heading, although the scan fits as well turned about the middle of the
circle. So the scan is turned about the point that it determines, and its cost has to rise as the slopes claim
(the counterpart of `scan_evidence` for the heading).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray, Int32Array, Uint16Array
from handcart.robotics.numerics.compiled import compiled_fast

from .likelihood_field import FieldValues
from .scan_evidence import MIN_POINTS, SHIFT_CELLS, ScanEvidence, _cost, _shifted_cost, near_points

MIN_TURN_SHARE = 0.2
"""Share of the rise that the slopes claim, below which the heading is not determined.

Measured in round rooms of 1.5 to 5 m radius with cells of 20 to 100 mm: up to 0.17; with 16 walls 0.13, with
12 walls 0.22, with 8 walls 0.44, in rectangular rooms 0.48 and more.
"""
PLAIN_TURN_SHARE = 0.4
"""Share from which the information by the slopes is used in full."""


class TurnEvidence(NamedTuple):
    """Information of a scan about the heading."""

    pivot: FloatArray
    """(2,) motion of the base on the map, in [m] for each [rad] of a turn, with which the scan's points stay
    on round walls."""
    share: float
    """Share of the information about that turn that the cost confirms, 0 to 1."""


def turn_evidence(
    grid: GridMap,
    facing: Uint16Array,
    points: FloatArray,
    reading: FieldValues,
    pose: Pose2,
    information: FloatArray,
    position: ScanEvidence,
    scale: float,
) -> TurnEvidence:
    """Return the evidence of a scan about the heading: the rise of its cost when it is turned.

    Args:
        grid: the map.
        facing: (k, h, w) distances of its cells to the nearest surface, as `LikelihoodField.facing`.
        points: (n, 2) end points of the beams, on the map, in [m].
        reading: values of the likelihood field at the points.
        pose: map_T_base at which the scan fits best.
        information: (3, 3) information matrix of the scan alone: x, y on the map and heading, in [1/m²] and
            [1/rad²].
        position: evidence about the position; the base does not slide along a direction without any.
        scale: scale of the robust cost, in [m].
    """
    pivot = _pivot(information, position)
    sectors, seen, distances, slopes = near_points(
        points, reading.distances, reading.slopes, 4.0 * scale, pose[:2], len(facing)
    )
    if not len(seen):
        return TurnEvidence(pivot, 0.0)
    middle = np.array([pose.x - pivot[1], pose.y + pivot[0]])
    steps, corner = SHIFT_CELLS * grid.resolution, (grid.origin_x, grid.origin_y)
    rises = turn_rises(
        steps, corner, grid.resolution, facing, sectors, seen, distances, slopes, middle, scale
    ).tolist()
    across = min(found / one for found, _, one in rises)
    claimed = min(claim / one for _, claim, one in rises)
    if across < max(MIN_POINTS, MIN_TURN_SHARE * claimed):
        return TurnEvidence(pivot, 0.0)
    return TurnEvidence(pivot, min(1.0, (across / max(claimed, 1e-9) / PLAIN_TURN_SHARE) ** 2))


def _pivot(information: FloatArray, position: ScanEvidence) -> FloatArray:
    """Return the motion (2,) of the base that costs least with a turn, in [m/rad]."""
    (xx, xy, xt), (_, yy, yt), _ = information.tolist()
    if position.share > 0.0:
        determinant = xx * yy - xy * xy
        if determinant > 1e-9 * max(xx, yy, 1e-9) ** 2:
            return np.array([(xy * yt - yy * xt) / determinant, (xy * xt - xx * yt) / determinant])
    across = np.array([-position.direction[1], position.direction[0]])
    lever = float(across @ information[:2, 2])
    return np.asarray(-across * lever / max(float(across @ information[:2, :2] @ across), 1e-9))


def without_turn(information: FloatArray, evidence: TurnEvidence) -> FloatArray:
    """Return a scan's information (3, 3) with that about the turn reduced to its share.

    What the scan says about the point that the turn leaves in place is kept.
    """
    less = 1.0 - math.sqrt(evidence.share)
    keep = np.eye(3)
    keep[:, 2] -= less * np.array([*evidence.pivot, 1.0])
    return np.asarray(keep.T @ information @ keep)


@compiled_fast
def turn_rises(
    steps: FloatArray,
    origin: tuple[float, float],
    resolution: float,
    facing: Uint16Array,
    sectors: Int32Array,
    points: FloatArray,
    distances: FloatArray,
    slopes: FloatArray,
    middle: FloatArray,
    scale: float,
) -> FloatArray:
    """Return how much the matching cost of a scan rises for a turn of it, plus that for the opposite turn.

    Args:
        steps: (n,) turns, each by the path of a point at the root mean square distance from `middle`, in [m].
        origin: lower-left corner of the map in its frame, in [m].
        resolution: side of a cell, in [m].
        facing: (s, h, w) distances of the cells to surfaces, as for `scan_evidence.rises`.
        sectors: (m,) index along the first axis of `facing` of the direction from each point to the lidar.
        points: (m, 2) of the scan on the map, in [m].
        distances: (m,) of the points to the nearest surface, in [m].
        slopes: (m, 2) slopes of the distances, without unit.
        middle: (2,) centre of the turn on the map, in [m].
        scale: scale of the robust cost, in [m].

    Returns:
        (n, 3) in [m²], for each turn: the actual rise, the rise expected from the slopes, and the rise of a
            single point that moves straight across a wall.
    """
    count, per = len(points), 1.0 / resolution
    out, before, reach = np.zeros((len(steps), 3)), 0.0, 0.0
    at, moved, plane = np.empty((2, count)), np.empty((2, count)), np.empty(count, dtype=np.int32)
    area = facing.shape[1] * facing.shape[2]
    for i in range(count):
        reach += (points[i, 0] - middle[0]) ** 2 + (points[i, 1] - middle[1]) ** 2
    reach = max(math.sqrt(reach / count), resolution)
    for i in range(count):
        at[0, i] = (points[i, 0] - origin[0]) * per - 0.5
        at[1, i] = (points[i, 1] - origin[1]) * per - 0.5
        moved[0, i] = (middle[1] - points[i, 1]) / reach * per
        moved[1, i] = (points[i, 0] - middle[0]) / reach * per
        plane[i] = sectors[i] * area
        before += _cost(distances[i] ** 2, scale)
    for j in range(len(steps)):
        forth = _shifted_cost(facing, plane, at, moved, steps[j], resolution, scale)
        back = _shifted_cost(facing, plane, at, moved, -steps[j], resolution, scale)
        out[j, 0] = forth + back - 2.0 * before
        out[j, 2] = 2.0 * _cost(steps[j] ** 2, scale)
        length = steps[j] * resolution
        for i in range(count):
            slope = slopes[i, 0] * moved[0, i] + slopes[i, 1] * moved[1, i]
            out[j, 1] += 2.0 * _cost((length * slope) ** 2, scale)
    return out
