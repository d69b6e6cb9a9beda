"""Search of all poses on a map from which a scan looks as it does."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import ANNEALING_SCALES_M, descend_scan
from handcart.robotics.navigation.scans.start_search import (
    COARSE_M,
    COARSE_POINTS,
    ScanBeams,
    score_poses,
    search_cells,
)
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, Uint16Array
from handcart.robotics.numerics.compiled import compiled

from .beam_evidence import explain

MAX_POSES = 1_600_000
HEADING_COUNT = 90
BIN_M, BIN_HEADINGS = 0.4, 4  # within which only the best pose is refined
MAX_REFINED = 1200
MAX_REFINED_HARD = 6000
"""Maximum number of poses to refine if the first ones do not explain the scan."""
PLAIN_LOG = -10.0  # log-likelihood of a scan that is explained
REFINE_POINTS = 90
SAME_M, SAME_RAD = 0.25, math.radians(10.0)  # within which two poses are the same place
KEPT_LOG = 60.0  # below the best log-likelihood, beyond which a pose is not kept
MAX_FOUND = 200


class Found(NamedTuple):
    """Poses of the base at which a scan fits the map, the best first, with their log-likelihoods."""

    poses: FloatArray
    """(n, 3) map_T_base, in [m, m, rad]."""
    log_likelihoods: FloatArray
    """Log-likelihoods (n,) of the scan from each pose."""


def search_map(field: LikelihoodField, beams: ScanBeams, noise: float) -> Found:
    """Return the poses, each at a different place of the map, at which a scan fits best.

    There are at most `MAX_FOUND` poses. Poses whose log-likelihood is lower than the best by more than
    `KEPT_LOG` are left out. There is no pose if the scan has fewer echoes than a third of `COARSE_POINTS`.

    Args:
        field: likelihood field of the map.
        beams: beams of the scan.
        noise: sigma of a point's distance to the map, in [m].
    """
    points = beams.points
    if len(points) < COARSE_POINTS // 3:
        return Found(np.empty((0, 3)), np.empty(0))
    rough = _coarse(field, points)
    some = points[np.linspace(0, len(points) - 1, min(len(points), REFINE_POINTS)).astype(np.int64)]
    refined, likely = np.empty((0, 3)), np.empty(0)
    for part in (rough[:MAX_REFINED], rough[MAX_REFINED:]):
        if len(part) and (not len(likely) or likely.max() < PLAIN_LOG):
            tried = refine_poses(field, some, part, noise, ANNEALING_SCALES_M)
            tried = tried[_can_stand(field, tried)]
            refined = np.vstack([refined, tried])
            likely = np.concatenate([likely, explain(field, beams, tried, noise).log_likelihood])
    order = _distinct(refined, np.argsort(-likely, kind="stable"))
    if not len(order):
        return Found(np.empty((0, 3)), np.empty(0))
    order = order[likely[order] >= likely[order[0]] - KEPT_LOG][:MAX_FOUND]
    fine = refine_poses(field, points, refined[order], noise, ())
    likely = explain(field, beams, fine, noise).log_likelihood
    order = _distinct(fine, np.argsort(-likely, kind="stable"))
    return Found(fine[order], likely[order])


def refine_poses(
    field: LikelihoodField, points: FloatArray, poses: FloatArray, noise: float, scales: tuple[float, ...]
) -> FloatArray:
    """Return the poses at which a scan fits the map best, one near each of `poses`.

    Args:
        field: likelihood field of the map.
        points: (m, 2) end points of the scan in the base frame, in [m].
        poses: (n, 3) map_T_base to begin at: x, y in [m], heading in [rad].
        noise: sigma of a point's distance to the map, in [m].
        scales: scales of the robust cost before the final one, in [m].

    Returns:
        (n, 3) map_T_base, in [m, m, rad].
    """
    grid = field.map
    every = np.array([*scales, 6.0 * noise, 2.5 * noise])
    corner = grid.origin_x, grid.origin_y
    begun = np.ascontiguousarray(poses, dtype=np.float64)
    dense = np.ascontiguousarray(points, dtype=np.float64)
    return np.asarray(
        _refine(field.facing, grid.occupied, dense, begun, corner, grid.resolution, every, noise)
    )


def same_place(poses: FloatArray, pose: FloatArray) -> BoolArray:
    """Return a mask (n,), True for poses that differ from a given pose by less than 0.25 m and 10 degrees.

    Args:
        poses: (n, 3) map_T_base: x, y in [m], heading in [rad].
        pose: (3,) given map_T_base: x, y in [m], heading in [rad].
    """
    away = np.hypot(poses[:, 0] - pose[0], poses[:, 1] - pose[1])
    turn = np.abs(np.remainder(poses[:, 2] - pose[2] + math.pi, 2.0 * math.pi) - math.pi)
    return np.asarray((away < SAME_M) & (turn < SAME_RAD))


def _can_stand(field: LikelihoodField, poses: FloatArray) -> BoolArray:
    """Return (n,) which of poses (n, 3) are on the map, and not in a wall."""
    grid = field.map
    fits = grid.inside(poses[:, :2])
    rows, columns = grid.to_cell(poses[fits, :2]).T
    fits[fits] = ~grid.occupied[rows, columns]
    return fits


def _distinct(poses: FloatArray, order: IntArray) -> IntArray:
    """Return the indices (k,) in `order` without poses of `poses` (n, 3) at the place of an earlier one."""
    left, kept = order, []
    while len(left):
        kept.append(int(left[0]))
        left = left[~same_place(poses[left], poses[left[0]])]
        if len(kept) >= 2 * MAX_FOUND:
            break
    return np.array(kept, dtype=np.int64)


def _coarse(field: LikelihoodField, points: FloatArray) -> FloatArray:
    """Return (n, 3) poses all over the map from which the points lie near what it shows, one for each bin."""
    grid = field.map
    cells, stride = search_cells(field, HEADING_COUNT, MAX_POSES)
    if not len(cells):
        return np.empty((0, 3))
    some = points[np.linspace(0, len(points) - 1, COARSE_POINTS).astype(np.int64)]
    turns = np.linspace(-math.pi, math.pi, HEADING_COUNT, endpoint=False)
    scores = score_poses(
        field.distance, cells, turns, np.ascontiguousarray(some) / grid.resolution, max(COARSE_M, stride)
    )
    chosen = _best_of_bins(scores, cells, max(1, round(BIN_M / grid.resolution)))
    cell, heading = np.divmod(chosen, HEADING_COUNT)
    return np.column_stack([grid.to_point(cells[cell]), turns[heading]])


def _best_of_bins(scores: FloatArray, cells: IntArray, size: int) -> IntArray:
    """Return the flat indices of the best scores (n, m), at most one in each bin of `size` cells."""
    flat = scores.ravel()
    many = min(len(flat), 40 * MAX_REFINED_HARD)
    top = np.argpartition(-flat, many - 1)[:many] if many < len(flat) else np.arange(len(flat))
    top = top[np.argsort(-flat[top], kind="stable")]
    cell, heading = np.divmod(top, scores.shape[1])
    rows, columns = np.divmod(cells[cell], size)[0].T
    keys = (rows * (int(columns.max()) + 1) + columns) * HEADING_COUNT + heading // BIN_HEADINGS
    _, first = np.unique(keys, return_index=True)
    return np.asarray(top[np.sort(first)][:MAX_REFINED_HARD])


@compiled
def _refine(
    facing: Uint16Array,
    occupied: BoolArray,
    points: FloatArray,
    poses: FloatArray,
    corner: tuple[float, float],
    resolution: float,
    scales: FloatArray,
    noise: float,
) -> FloatArray:
    """Return (n, 3) the poses after Gauss-Newton at each scale."""
    out = np.empty_like(poses)
    nothing, direction = np.zeros((3, 3)), np.array([1.0, 0.0])
    for m in range(len(poses)):
        pose = poses[m].copy()
        for k in range(len(scales)):
            pose, _ = descend_scan(
                facing,
                occupied,
                points,
                pose,
                poses[m],
                nothing,
                direction,
                1.0,
                corner,
                resolution,
                scales[k],
                noise,
            )
        out[m] = pose
    return out
