"""Comparison of two maps: where one lies on the other, and how far apart their walls are."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField, match_scan
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray

COARSE_M = 0.2
"""Side of a cell, in [m], in the search for the alignment."""
TURN_STEP_RAD = math.radians(1.0)
MAX_COARSE_POINTS = 4000
BLUR_CELLS = 1.0
HYPOTHESIS_COUNT = 8
START_COVARIANCE = np.diag([0.5, 0.5, 0.1]) ** 2
"""Covariance (3, 3) of a hypothesis, in [m, m, rad]."""
SAME_WALL_M = 0.25
"""Distance in [m] from which on a wall is missing in the other map."""


class MapComparison(NamedTuple):
    """Result of comparing the walls of two maps, with the alignment of the maps and distances between their
    walls.
    """

    first_T_second: Pose2
    """Pose of the second map's frame in the frame of the first."""
    first: FarArray
    """(n,) distance of each wall cell of the first map to the nearest one of the second, in [m]; infinity
    outside what the second map knows.
    """
    second: FarArray
    """(m,) distance of each wall cell of the second map to the nearest one of the first, in [m]; infinity
    outside what the first map knows.
    """

    def figures(self, distances: FarArray) -> tuple[float, float, float]:
        """Return median and 95 % quantile of the distances of walls that are on both maps, in [m], and the
        share of missing walls.

        A wall cell is on both maps if its distance from a wall of the other map is at most `SAME_WALL_M`.
        Otherwise it is missing. Wall cells at places that the other map does not know are not counted. If no
        wall cell is on both maps, median and quantile are NaN, and the share is 1. All three are NaN if no
        wall cell is counted.

        Args:
            distances: (n,) distance of each wall cell of one map to the nearest wall cell of the other, in
                [m]; infinity where the other map is unknown.
        """
        known = distances[np.isfinite(distances)]
        if not len(known):
            return math.nan, math.nan, math.nan
        near = known[known <= SAME_WALL_M]
        if not len(near):
            return math.nan, math.nan, 1.0
        return float(np.median(near)), float(np.quantile(near, 0.95)), 1.0 - len(near) / len(known)


def wall_points(grid: GridMap) -> FloatArray:
    """Return the centres (n, 2), on the map in [m], of occupied cells that have a neighbour that is not
    occupied.
    """
    solid = grid.occupied.astype(np.uint8)
    inner = cv2.erode(solid, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=1)
    return grid.to_point(np.argwhere(grid.occupied & (inner == 0)))


def compare_maps(first: GridMap, second: GridMap, alignment: Pose2 | None = None) -> MapComparison:
    """Compare the walls of two maps, after moving the second map to where it fits the first one best.

    Args:
        first: a map with walls.
        second: another map.
        alignment: first_T_second, by which the second map is moved; None: the best one is searched.
    """
    one, other = wall_points(first), wall_points(second)
    pose = _align(first, one, other) if alignment is None else alignment
    return MapComparison(
        pose,
        _distances(one, pose.apply(other), pose.inverse(), second),
        _distances(other, pose.inverse().apply(one), pose, first),
    )


def _distances(points: FloatArray, others: FloatArray, other_T_own: Pose2, other: GridMap) -> FarArray:
    """Return the distance (n,) of points to the nearest of the others; infinity where nothing is known."""
    from scipy.spatial import cKDTree

    found: FloatArray = cKDTree(others).query(points)[0]
    moved = other_T_own.apply(points)
    seen = _near_known(other)
    inside = other.inside(moved)
    known = np.zeros(len(points), np.bool_)
    cells = other.to_cell(moved[inside])
    known[inside] = seen[cells[:, 0], cells[:, 1]]
    return np.where(known, found, np.inf)


def _near_known(grid: GridMap) -> BoolArray:
    """Return (h, w) whether a cell is known, or next to one: a wall's own cells may be unknown."""
    known = (~grid.unknown).astype(np.uint8)
    size = 2 * max(1, math.ceil(SAME_WALL_M / grid.resolution)) + 1
    return cv2.dilate(known, np.ones((size, size), np.uint8)) > 0


def _align(first: GridMap, one: FloatArray, other: FloatArray) -> Pose2:
    """Return the pose at which the points `other` (m, 2) fit a map with the points `one` (n, 2) best.

    All turns are tried; for each, the shift is the peak of the correlation of both pictures (by Fourier
    transform), and the best are refined in the map's field of distances.
    """
    stride = max(1, len(other) // MAX_COARSE_POINTS)
    middle = other.mean(axis=0)
    thinned = other[::stride] - middle
    low = one.min(axis=0)
    reach = 2.0 * float(np.hypot(*thinned.T).max())
    size = np.ceil((np.ptp(one, axis=0) + reach) / COARSE_M).astype(int) + 4
    width, height = (int(cv2.getOptimalDFTSize(int(item))) for item in size)
    shape = width, height
    picture = np.fft.rfft2(_raster(one - low, shape, True))
    found = list[tuple[float, Pose2]]()
    for turn in np.arange(-math.pi, math.pi, TURN_STEP_RAD):
        turned = Pose2(0.0, 0.0, float(turn)).apply(thinned)
        corner = turned.min(axis=0)
        scores = np.fft.irfft2(
            picture * np.conj(np.fft.rfft2(_raster(turned - corner, shape, False))), s=shape
        )
        x, y = np.unravel_index(int(np.argmax(scores)), scores.shape)
        shift = np.array([x, y]) - shape * (np.array([x, y]) > np.array(shape) - reach / COARSE_M)
        place = low - corner + shift * COARSE_M
        centre = Pose2(float(place[0]), float(place[1]), float(turn))
        moved = centre.compose(Pose2(-float(middle[0]), -float(middle[1]), 0.0))
        found.append((float(scores[x, y]), moved))
    found.sort(key=lambda pair: -pair[0])
    field = LikelihoodField(
        first, is_drawn=True
    )  # the points are cells of walls, not ends of beams: no side faces a sensor
    refined = [_refined(field, other[::stride], pose) for _, pose in found[:HYPOTHESIS_COUNT]]
    return max(refined, key=lambda item: item[0])[1]


def _raster(points: FloatArray, shape: tuple[int, int], is_blurred: bool) -> SingleArray:
    """Return the picture (x, y) of points from the corner on."""
    picture = np.zeros(shape, np.float32)
    cells = (points / COARSE_M).astype(int)
    picture[cells[:, 0], cells[:, 1]] = 1.0
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), BLUR_CELLS), np.float32) if is_blurred else picture


def _refined(field: LikelihoodField, points: FloatArray, pose: Pose2) -> tuple[float, Pose2]:
    """Return the share of points (n, 2) that the first map explains at the refined pose, and the pose."""
    match = match_scan(field, points, pose, START_COVARIANCE, sigma=field.map.resolution, anneal=True)
    return match.inliers, match.pose
