"""Matching a range scan with a map: robust Gauss-Newton on a likelihood field.

The field is the distance to the nearest occupied surface cell (Thrun, Burgard and Fox, 2005, section 6.4),
read between cell centres by bilinear interpolation. A surface lies somewhere in its cell, on average at the
centre: measured from the cells' edges a pose comes out twice as wrong.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.compiled import compiled

INLIER = 3.0  # scales within which a point counts as explained by the map
CELL_BIAS = 0.25  # of a cell: what a pose is wrong by because surfaces lie anywhere in their cells
_LEAST = 1e-6 * np.eye(3)  # of an information: what is seen may not tell all of a pose
ANNEALED = (0.5, 0.35, 0.25, 0.17, 0.12)  # scales in [m] tried before the final one from a bad start


class LikelihoodField:
    """Distances to the surfaces of a map, ready for matching scans."""

    def __init__(self, grid: GridMap) -> None:
        """Compute the field; takes about a millisecond for 100,000 cells."""
        solid = grid.occupied.astype(np.uint8)
        inner = cv2.erode(solid, np.ones((3, 3), dtype=np.uint8), borderType=cv2.BORDER_REPLICATE)
        away = (solid == inner).astype(np.uint8)
        self.map = grid
        if away.all():
            self.distance = np.full(away.shape, np.inf, dtype=np.float32)
        else:
            cells = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            self.distance = (cells * grid.resolution).astype(np.float32)

    def read(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance (n,) in [m] of points (n, 2) of the map to the nearest surface; inf outside the map."""
        distances: NDArray[np.float64] = _read(self.distance, self.map.occupied, self._scaled(points))[:, 0]
        return distances

    def _scaled(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Column and row (n, 2), cell centres at whole numbers."""
        grid = self.map
        return (points - (grid.origin_x, grid.origin_y)) / grid.resolution - 0.5


class ScanMatch(NamedTuple):
    """Where a scan fits the map best."""

    pose: Pose2
    """map_T_base."""
    covariance: NDArray[np.float64]
    """(3, 3) of x, y in [m] and heading in [rad]; prior, sensor noise and the map's cells all in it."""
    spread: NDArray[np.float64]
    """(3, 3), the same without the map's cells: how far matches from one place lie apart."""
    inliers: float
    """Share of the points that the map explains, 0 to 1."""
    residuals: FarArray
    """(n,) distance of each point to the nearest surface, in [m]; inf outside the map."""


@compiled
def _read(
    distance: NDArray[np.float32], occupied: NDArray[np.bool_], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Distance, its bilinear slopes along x and y per cell, 1 in solids: (n, 4); inf and zeros outside."""
    height, width = distance.shape
    out = np.zeros((len(at), 4))
    for i in range(len(at)):
        column, row = math.floor(at[i, 0]), math.floor(at[i, 1])
        if not (0 <= column < width - 1 and 0 <= row < height - 1):
            out[i, 0] = np.inf  # a whole row at once would take two seconds more to compile
            continue
        u, v = at[i, 0] - column, at[i, 1] - row
        a, b = distance[row, column], distance[row, column + 1]
        c, d = distance[row + 1, column], distance[row + 1, column + 1]
        out[i, 0] = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v
        out[i, 1] = (b - a) * (1 - v) + (d - c) * v
        out[i, 2] = (c - a) * (1 - u) + (d - b) * u
        out[i, 3] = occupied[int(row + v + 0.5), int(column + u + 0.5)]
    return out


@compiled
def _normal_equations(
    distance: NDArray[np.float32],
    occupied: NDArray[np.bool_],
    points: NDArray[np.float64],
    middle: tuple[float, float],
    origin: tuple[float, float],
    resolution: float,
    scale: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Hessian (3, 3) and gradient (3,) of the points' robust cost, weights of Geman and McClure.

    The points (n, 2) are those of the map, `middle` the base on it, `origin` the map's corner, all in [m].
    A point inside a solid that would be drawn on along its beam is left out: that way is the wall's back.
    """
    hessian = np.zeros((3, 3))
    gradient = np.zeros(3)
    slope = np.empty(3)
    at = np.empty((len(points), 2))
    for i in range(len(points)):
        at[i, 0] = (points[i, 0] - origin[0]) / resolution - 0.5
        at[i, 1] = (points[i, 1] - origin[1]) / resolution - 0.5
    readings = _read(distance, occupied, at)
    for i in range(len(points)):
        residual = readings[i, 0]
        if residual > 4.0 * scale:
            continue
        weight = 1.0 / (1.0 + (residual / scale) ** 2) ** 2
        slope[0], slope[1] = readings[i, 1] / resolution, readings[i, 2] / resolution
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
    points: NDArray[np.float64],
    prior: Pose2,
    prior_covariance: NDArray[np.float64],
    sigma: float = 0.01,
    anneal: bool = False,
) -> ScanMatch:
    """The pose from which the scan looks like the map.

    Args:
        field: of the map.
        points: (n, 2) where beams ended, in the base frame, in [m].
        prior: map_T_base as odometry has it.
        prior_covariance: (3, 3) of the prior, in [m, m, rad].
        sigma: noise of a range, in [m].
        anneal: start from far: up to about 0.3 m and 10 degrees off. The robust scale then shrinks slowly and
            the prior counts only at the end.
    """
    noise = math.hypot(
        sigma, 0.3 * field.map.resolution
    )  # a uniform place in a cell has 0.29 cells of spread
    final = 2.5 * noise
    information = np.asarray(np.linalg.inv(prior_covariance + 1e-12 * np.eye(3)), dtype=np.float64)
    pose = prior
    for scale in (*ANNEALED, final) if anneal else (3.0 * final, final):
        trust = information if scale <= final or not anneal else 0.0 * information
        pose, hessian = _descend(field, points, pose, prior, trust, scale, noise)
    residuals = field.read(pose.apply(points)) if len(points) else np.empty(0)
    inliers = float(np.mean(residuals < INLIER * noise)) if len(points) else 0.0
    spread = np.asarray(np.linalg.inv(hessian + 1e-9 * np.eye(3)), dtype=np.float64)
    return ScanMatch(pose, spread + _cells(points, field.map.resolution), spread, inliers, residuals)


def _descend(
    field: LikelihoodField,
    points: NDArray[np.float64],
    pose: Pose2,
    prior: Pose2,
    information: NDArray[np.float64],
    scale: float,
    noise: float,
) -> tuple[Pose2, NDArray[np.float64]]:
    """Gauss-Newton at one robust scale: the pose and its information (3, 3)."""
    resolution, origin = field.map.resolution, (field.map.origin_x, field.map.origin_y)
    total: NDArray[np.float64] = information
    for _ in range(12):
        moved = pose.apply(points)
        middle = float(pose.x), float(pose.y)
        hessian, gradient = _normal_equations(
            field.distance, field.map.occupied, moved, middle, origin, resolution, scale
        )
        off = np.array([pose.x - prior.x, pose.y - prior.y, wrap(pose.theta - prior.theta)])
        total = hessian / noise**2 + information
        step = -np.linalg.solve(total + _LEAST, gradient / noise**2 + information @ off)
        x, y, turn = step.tolist()
        pose = Pose2(pose.x + x, pose.y + y, wrap(pose.theta + turn))
        if abs(x) + abs(y) < 1e-5 and abs(turn) < 1e-5:
            break
    return pose, total


def _cells(points: NDArray[np.float64], resolution: float) -> NDArray[np.float64]:
    """(3, 3) of what no number of beams averages away: where surfaces lie in their cells."""
    reach = math.sqrt(float(np.mean(points**2)) + 0.01) if len(points) else 1.0
    bias = CELL_BIAS * resolution
    return np.diag([bias**2, bias**2, (0.5 * bias / reach) ** 2])
