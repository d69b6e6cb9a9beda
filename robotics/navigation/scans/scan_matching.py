"""Matching a range scan with a map: robust Gauss-Newton on a likelihood field."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Uint16Array
from handcart.robotics.numerics.compiled import compiled

from .likelihood_field import LikelihoodField as LikelihoodField
from .likelihood_field import beam_sectors, read_field
from .scan_evidence import ScanEvidence, confirmed, near_surfaces, unrelated, weakest_evidence
from .turn_evidence import turn_evidence, without_turn

INLIER_SCALES = 3.0  # scales within which a point counts as explained by the map
OF_SIGMA = 0.6745  # of a normal error's sigma: half of the errors are smaller
CELL_SIGMA = 0.3  # of a cell: spread of a surface that lies anywhere in its cell
CELL_BIAS = 0.3  # of a cell: error of a pose by one wall, because surfaces lie anywhere in their cells
FEWEST_POINTS = 20  # points of which an explained share says something
MIN_INFORMATION_SHARE = 1e-6  # of an information: a scan may not determine all of a pose
HELD_HEADING = np.diag([0.0, 0.0, 1e10])
"""Information in [1/rad²] that keeps the heading of the prior where the scan does not determine it."""
ANNEALING_SCALES_M = (
    0.5,
    0.35,
    0.25,
    0.17,
    0.12,
)  # scales in [m] tried before the final one from a bad start


class ScanMatch(NamedTuple):
    """Pose at which a scan fits the map best, with its covariance and the quality of the fit."""

    pose: Pose2
    """map_T_base."""
    covariance: FloatArray
    """(3, 3) of x, y on the map in [m] and heading in [rad], by prior, sensor noise and the map's error."""
    map_error: FloatArray
    """(3, 3) factor W of the map's share W Wᵀ in `covariance`, rows as there; the same at one place."""
    kept: FloatArray
    """Matrix (3, 3) from the prior's error (x, y, heading) to its part in the pose; 0 by the scan alone."""
    spread: FloatArray
    """Covariance (3, 3) of matches from one place, in the units of `covariance`, without the error of the
    map's cells, and with the noise that the scan shows if that is more than the stated noise."""
    evidence: ScanEvidence
    """Information of this scan alone about the direction that it determines worst."""
    inliers: float
    """Share of the used points that the map explains, 0 to 1."""
    residuals: FarArray
    """(m,) distance of each used point to the nearest surface, in [m]; inf outside the map. All are used
    but those near things that may have moved."""


@compiled
def _normal_equations(
    facing: Uint16Array,
    occupied: BoolArray,
    points: FloatArray,
    middle: tuple[float, float],
    origin: tuple[float, float],
    resolution: float,
    scale: float,
) -> tuple[FloatArray, FloatArray]:
    """Hessian (3, 3) and gradient (3,) of the points' robust cost, weights of Geman and McClure.

    The points (n, 2) are those of the map, `middle` the base on it, `origin` the map's corner, all in [m].
    A point inside a solid that would be drawn on along its beam is skipped: that way is the wall's back.
    """
    hessian, gradient, slope = np.empty((3, 3)), np.empty(3), np.empty(3)
    for j in range(3):
        gradient[j] = 0.0
        for k in range(3):
            hessian[j, k] = 0.0
    at = np.empty((len(points), 2))
    for i in range(len(points)):
        at[i, 0] = (points[i, 0] - origin[0]) / resolution - 0.5
        at[i, 1] = (points[i, 1] - origin[1]) / resolution - 0.5
    readings = read_field(facing, occupied, at, beam_sectors(points, middle, len(facing)))
    for i in range(len(points)):
        residual = readings[i, 0] * resolution
        if residual > 4.0 * scale:
            continue
        weight = 1.0 / (1.0 + (residual / scale) ** 2) ** 2
        slope[0], slope[1] = readings[i, 1], readings[i, 2]
        x, y = points[i, 0] - middle[0], points[i, 1] - middle[1]
        if readings[i, 3] and slope[0] * x + slope[1] * y < 0.0 and residual > 0.5 * resolution:
            continue
        slope[2] = slope[1] * x - slope[0] * y
        for j in range(3):
            gradient[j] += weight * slope[j] * residual
            for k in range(3):
                hessian[j, k] += weight * slope[j] * slope[k]
    return hessian, gradient


def match_scan(
    field: LikelihoodField,
    points: FloatArray,
    prior: Pose2,
    prior_covariance: FloatArray,
    sigma: float = 0.01,
    anneal: bool = False,
    map_error: FloatArray | None = None,
    before: ScanEvidence | None = None,
) -> ScanMatch:
    """Return the pose near a prior at which a scan fits the map best, with its covariance.

    Points near things that may have moved (`GridMap.movable`) are used to find a distant pose, but not for
    its final value: neither pose nor covariance depends on these points.

    Args:
        field: likelihood field of the map.
        points: (n, 2) end points of the beams in the base frame, in [m].
        prior: map_T_base by odometry.
        prior_covariance: (3, 3) of the prior, x, y on the map in [m] and heading in [rad].
        sigma: noise of a range, in [m].
        anneal: True to start from far: up to about 0.3 m and 10 degrees off. The robust scale then shrinks
            slowly and the prior counts only at the end.
        map_error: (3, 3) factor W with rows for x, y on the map in [m] and heading in [rad]; W Wᵀ is the part
            of `prior_covariance` that comes from the map's error; None: zero.
        before: evidence of the previous scan, at about the same place, which has to confirm the evidence of
            this scan; None: there is none to compare with.
    """
    noise = math.hypot(sigma, CELL_SIGMA * field.map.resolution)
    final = 2.5 * noise
    information = _inverse(prior_covariance)
    grid, near, points = field.map, np.array(prior, dtype=np.float64), np.ascontiguousarray(points)
    found, evidence = near, ScanEvidence(np.array([1.0, 0.0]), 1.0)
    seen, used = evidence, points

    def descend(trust: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
        where = (grid.origin_x, grid.origin_y), grid.resolution
        return descend_scan(
            field.facing, grid.occupied, used, found, near, trust, *seen[:2], *where, scale, noise
        )

    for scale in (*ANNEALING_SCALES_M, final) if anneal else (3.0 * final, final):
        if scale <= final or not anneal:
            used = field.fixed(points, Pose2(*found.tolist()))
        found, hessian = descend(information if scale <= final or not anneal else 0.0 * information, scale)
    pose, residuals = Pose2(*found.tolist()), np.empty(0)
    if len(used):
        on_map = pose.apply(used)
        reading = field.reading(on_map, pose[:2])
        residuals, alone = reading.distances, hessian - information
        close = near_surfaces(field, on_map, reading, pose, final)
        evidence = weakest_evidence(grid, field.facing, close, pose, alone, final, noise)
        turn = turn_evidence(grid, field.facing, close, pose, alone, evidence, final)
        evidence = evidence._replace(turn_share=turn.share)
        seen = confirmed(evidence, before)
        if seen.share < 1.0:
            information = _inverse(unrelated(prior_covariance, seen))
            found, hessian = descend(information, final)
            pose = Pose2(*found.tolist())
            residuals = field.reading(pose.apply(used), pose[:2]).distances
        held = information
        if seen.turn_share == 0.0:
            held = information + HELD_HEADING
            found, hessian = descend(held, final)
            pose = Pose2(*found.tolist())
            residuals = field.reading(pose.apply(used), pose[:2]).distances
        hessian[:2, :2] += seen.more * seen.direction[:, None] * seen.direction
        if seen.turn_share < 1.0:
            turn = turn._replace(share=seen.turn_share)
            hessian = information + without_turn(hessian - held, turn)
    count = max(len(used), min(len(points), FEWEST_POINTS))  # that are left must explain something
    inliers = np.count_nonzero(residuals < INLIER_SCALES * noise) / count if count else 0.0
    fit = _inverse(hessian, 1e-9)
    kept = fit @ information
    covariance, error = _posterior(fit, kept, _cells(used, field.map.resolution), map_error)
    spread = _excess(residuals, noise) * fit
    return ScanMatch(pose, covariance, error, kept, spread, evidence, inliers, residuals)


def _inverse(covariance: FloatArray, small: float = 1e-12) -> FloatArray:
    """Return the inverse of a symmetric matrix (3, 3), from L D Lᵀ, with `small` added to the diagonal.

    By hand: a call of LAPACK takes ten times as long. Minors would lose too much where it is almost singular.
    """
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = covariance.tolist()
    first = xx + small
    if first > 0.0:
        a, b = xy / first, xt / first
        second, rest = yy + small - a * xy, yt - a * xt
        if second > 0.0:
            c = rest / second
            third = tt + small - b * xt - c * rest
            if third > 0.0:
                d = a * c - b
                one, two = 1.0 / first + a * a / second + d * d / third, -a / second - c * d / third
                four, low = 1.0 / second + c * c / third, (d / third, -c / third)
                return np.array([[one, two, low[0]], [two, four, low[1]], [*low, 1.0 / third]])
    return np.asarray(np.linalg.inv(covariance + small * np.eye(3)), dtype=np.float64)


def _posterior(
    fit: FloatArray,
    kept: FloatArray,
    cells: FloatArray,
    before: FloatArray | None,
) -> tuple[FloatArray, FloatArray]:
    """Covariance (3, 3) and factor (3, 3) of the map's share in it (Schmidt, 1966).

    The map errs alike in all scans at one place: no number of them averages that away. Along a direction that
    the scan does not determine, the gain is zero and the prior stays.

    Args:
        fit: (3, 3) covariance of the pose if the map had no errors, and the prior neither.
        kept: (3, 3) matrix from the prior's error to its part in the pose.
        cells: (3, 3) factor of the map's error in what a scan alone says.
        before: (3, 3) factor of the map's share in the prior; none if None.
    """
    gain = np.eye(3) - kept
    old = np.zeros((3, 3)) if before is None else before
    error = kept @ old + gain @ cells
    independent = fit - kept @ (old @ old.T) @ kept.T
    return independent + error @ error.T, error


@compiled
def descend_scan(
    facing: Uint16Array,
    occupied: BoolArray,
    points: FloatArray,
    start: FloatArray,
    prior: FloatArray,
    information: FloatArray,
    direction: FloatArray,
    share: float,
    origin: tuple[float, float],
    resolution: float,
    scale: float,
    noise: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the pose that fits a scan best at one robust scale, by Gauss-Newton.

    Poses are map_T_base: x, y in [m] and heading in [rad].

    Args:
        facing: (k, h, w) distances of cells to surfaces that face each of k beam directions
            (`LikelihoodField.facing`), in steps of 1 / `STEPS_PER_CELL` cells.
        occupied: (h, w) cells of the map.
        points: (n, 2) points of the scan in the base frame, in [m].
        start: (3,) pose at which the iteration begins.
        prior: (3,) expected pose.
        information: (3, 3) of the expected pose, x, y on the map and heading, in [1/m²] and [1/rad²].
        direction: (2,) unit vector on the map along which the scan has less information.
        share: share of the scan's information about the position along `direction` that is kept.
        origin: x, y of the map's lower-left cell centre, in [m].
        resolution: side of a cell, in [m].
        scale: scale of the robust weights, in [m].
        noise: sigma of a range, in [m].

    Returns:
        The pose (3,), and its information (3, 3) along the same axes, in [1/m²] and [1/rad²].
    """
    pose, off = np.empty(3), np.empty(3)
    moved, total = np.empty((len(points), 2)), np.empty((3, 3))
    pose[0], pose[1], pose[2] = start[0], start[1], start[2]
    for _ in range(12):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        for i in range(len(points)):
            moved[i, 0] = points[i, 0] * cos - points[i, 1] * sin + pose[0]
            moved[i, 1] = points[i, 0] * sin + points[i, 1] * cos + pose[1]
        hessian, gradient = _normal_equations(
            facing, occupied, moved, (pose[0], pose[1]), origin, resolution, scale
        )
        _thin(hessian, gradient, direction, share)
        off[0], off[1], off[2] = pose[0] - prior[0], pose[1] - prior[1], wrapped(pose[2] - prior[2])
        for j in range(3):
            gradient[j] /= noise**2
            for k in range(3):
                total[j, k] = hessian[j, k] / noise**2 + information[j, k]
                gradient[j] += information[j, k] * off[k]
        x, y, turn = _solved(total, gradient)
        pose[0], pose[1], pose[2] = pose[0] - x, pose[1] - y, wrapped(pose[2] - turn)
        if abs(x) + abs(y) < 1e-5 and abs(turn) < 1e-5:
            break
    return pose, total


@compiled
def _thin(hessian: FloatArray, gradient: FloatArray, direction: FloatArray, share: float) -> None:
    """Reduce the points' information on the position along a direction (2,) to a share, in place."""
    less = 1.0 - math.sqrt(share)
    pull = gradient[0] * direction[0] + gradient[1] * direction[1]
    along = np.empty(3)
    for j in range(3):
        along[j] = hessian[j, 0] * direction[0] + hessian[j, 1] * direction[1]
    inner = along[0] * direction[0] + along[1] * direction[1]
    for j in range(2):
        gradient[j] -= (1.0 - share) * pull * direction[j]
        hessian[j, 2] -= less * along[2] * direction[j]
        hessian[2, j] = hessian[j, 2]
        for k in range(2):
            hessian[j, k] -= less * (along[j] * direction[k] + direction[j] * along[k])
            hessian[j, k] += less**2 * inner * direction[j] * direction[k]


@compiled
def wrapped(angle: float) -> float:
    """Return the angle wrapped to (-pi, pi], in [rad], in compiled code."""
    return -((math.pi - angle) % (2.0 * math.pi) - math.pi)


@compiled
def _solved(matrix: FloatArray, right: FloatArray) -> tuple[float, float, float]:
    """Return the x of (matrix + LEAST) x = right, the matrix (3, 3) symmetric: Cholesky, by hand because
    numba takes two seconds to compile a call of LAPACK.
    """
    a = math.sqrt(matrix[0, 0] + MIN_INFORMATION_SHARE)
    b, c = matrix[1, 0] / a, matrix[2, 0] / a
    d = math.sqrt(matrix[1, 1] + MIN_INFORMATION_SHARE - b * b)
    e = (matrix[2, 1] - b * c) / d
    f = math.sqrt(matrix[2, 2] + MIN_INFORMATION_SHARE - c * c - e * e)
    x = right[0] / a
    y = (right[1] - b * x) / d
    z = (right[2] - c * x - e * y) / f / f
    y = (y - e * z) / d
    return (x - b * y - c * z) / a, y, z


def _excess(residuals: FloatArray, noise: float) -> float:
    """Return the factor, at least 1, by which a scan varies more than the sensor's stated noise."""
    if not len(residuals):
        return 1.0
    middle = min(_median(residuals), INLIER_SCALES * noise)
    return max(1.0, (middle / OF_SIGMA / noise) ** 2)


def _median(values: FloatArray) -> float:
    """Return the median of (n,) numbers without NaN; the upper one of two middle ones."""
    half = len(values) // 2
    return float(np.partition(values, half)[half])


def _cells(points: FloatArray, resolution: float) -> FloatArray:
    """Return a factor (3, 3) of the error that more beams do not reduce: the depth of surfaces in cells."""
    reach = math.sqrt(float(np.vdot(points, points)) / points.size + 0.01) if len(points) else 1.0
    bias = CELL_BIAS * resolution
    return np.diag([bias, bias, 0.5 * bias / reach])
