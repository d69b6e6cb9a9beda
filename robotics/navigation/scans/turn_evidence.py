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
from handcart.robotics.numerics.arrays import FloatArray, Uint16Array

from .scan_evidence import MIN_POINTS, SHIFT_CELLS, NearPoints, ScanEvidence, rises

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
    near: NearPoints,
    pose: Pose2,
    information: FloatArray,
    position: ScanEvidence,
    scale: float,
) -> TurnEvidence:
    """Return the evidence of a scan about the heading: the rise of its cost when it is turned.

    Args:
        grid: the map.
        facing: (k, h, w) distances of its cells to the nearest surface, as `LikelihoodField.facing`.
        near: points of the scan near surfaces of the map, at this pose.
        pose: map_T_base at which the scan fits best.
        information: (3, 3) information matrix of the scan alone: x, y on the map and heading, in [1/m²] and
            [1/rad²].
        position: evidence about the position; the base does not slide along a direction without any.
        scale: scale of the robust cost, in [m].
    """
    pivot = _pivot(information, position)
    sectors, seen, distances, slopes = near
    if not len(seen):
        return TurnEvidence(pivot, 0.0)
    middle = np.array([pose.x - pivot[1], pose.y + pivot[0]])
    # By the path of a point at the root mean square distance, which a step moves by its length.
    reach = max(math.sqrt(((seen - middle) ** 2).sum() / len(seen)), grid.resolution)
    turn, corner = np.array([[0.0, 0.0, -1.0 / reach]]), (grid.origin_x, grid.origin_y)
    where = turn, SHIFT_CELLS * grid.resolution, 1, corner, grid.resolution, facing, sectors, seen
    turned = rises(*where, distances, slopes, middle, scale)[0].tolist()
    across = min(found / one for found, _, one in turned)
    claimed = min(claim / one for _, claim, one in turned)
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
