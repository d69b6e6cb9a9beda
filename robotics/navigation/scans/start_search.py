"""Test of a stated start by a scan, against all other places of the map."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from handcart.robotics.numerics.compiled import compiled

from .likelihood_field import LikelihoodField
from .scan_matching import INLIER_SCALES, match_scan, wrapped

PLAIN_FIT = 0.93  # share of the beams that the map explains; no less, and no other place is looked for
SURE_FIT = 0.9  # share from which an unstated place is accepted
MIN_SHARE_GAIN = 0.04  # of the beams that another place has to explain beyond the stated one
MUCH_BETTER = 0.15  # the same of a place that is not sure itself
NEAR_M, NEAR_RAD = 0.25, math.radians(10.0)  # within which two poses are the same place
CLEAR_M = 0.15  # of a base from what the map shows
MAX_POSES = 400_000
MIN_STRIDE_M = 0.1
HEADING_COUNT = 72
COARSE_M = 0.15  # scale of the first search
COARSE_POINTS = 60
MAX_CANDIDATES = 240  # along a corridor many poses are nearly equal, and crowd out a better one at its end
PLAUSIBLE_M = 5.0  # from the stated start; farther off, a place that looks alike may have been missed
AT_SURFACE = 0.2  # cells from a surface, where a beam ends
SHORT_OF_REACH = 0.9  # of the reach: nearer surfaces of the map must return an echo
CANDIDATE_COVARIANCE = np.diag([0.3, 0.3, 0.17]) ** 2  # [m², rad²] of a candidate


class ScanBeams(NamedTuple):
    """Lidar scan, given by the angle and range of each beam in the base frame."""

    origin: FloatArray
    """(2,) of the sensor, in the base frame, in [m]."""
    angles: FloatArray
    """(n,) in the base frame, in [rad]."""
    ranges: FloatArray
    """(n,) in [m]; infinity where nothing came back, NaN where nothing is known."""
    reach: float
    """Maximum range of the lidar, in [m]."""

    @property
    def points(self) -> FloatArray:
        """Points (m, 2) where beams ended, in the base frame, in [m]."""
        hit = np.isfinite(self.ranges)
        rays = np.column_stack([np.cos(self.angles[hit]), np.sin(self.angles[hit])])
        return np.asarray(self.origin + self.ranges[hit, None] * rays)


class StartFit(NamedTuple):
    """Result of comparing a scan with the map at a stated start pose and at other poses.

    A beam is explained if it agrees with the map (see `explained_share`). The result holds the share of beams
    explained at the stated pose, and a place, if there is one, with a share larger by at least
    `MIN_SHARE_GAIN`.
    """

    share: float
    """Share of the beams, 0 to 1, that the map explains from the stated start."""
    other: Pose2 | None = None
    """map_T_base of a place from which the map clearly explains more beams; None without one.

    It explains `MIN_SHARE_GAIN` more, and `SURE_FIT` of all or `MUCH_BETTER` more.
    """
    is_sure: bool = False
    """True if `other` is the only such place, and the map explains `SURE_FIT` of all beams from there.

    It also has to be within `PLAUSIBLE_M` of the stated start.
    """

    @property
    def contradicts(self) -> bool:
        """True if the map explains clearly more beams from another place than from the stated start
        (`other`).
        """
        return self.other is not None


def explained_share(field: LikelihoodField, beams: ScanBeams, pose: Pose2, noise: float) -> float:
    """Return the share of a scan's beams, 0 to 1, that agree with the map at a pose.

    A beam with an echo agrees if it ends near a surface of the map. A beam without an echo agrees if the beam
    meets no surface of the map within the lidar's reach.

    Args:
        field: likelihood field of the map.
        beams: beams of the scan.
        pose: map_T_base.
        noise: sigma of a point's distance to the map, in [m].
    """
    known = ~np.isnan(beams.ranges)
    if not known.any():
        return 0.0
    hits = int((field.read(pose.apply(beams.points)) < INLIER_SCALES * noise).sum())
    silent = beams.angles[np.isinf(beams.ranges)]
    x, y = pose.apply(beams.origin[None])[0]
    clear = map_ranges(field, Pose2(float(x), float(y), pose.theta), silent, beams.reach)
    free = int((clear > SHORT_OF_REACH * beams.reach).sum())
    return (hits + free) / int(known.sum())


def check_start(field: LikelihoodField, beams: ScanBeams, pose: Pose2, noise: float) -> StartFit:
    """Search for another place where a scan fits the map better than at the stated pose, and return the
    result.

    Nothing is searched if the share of beams that agree with the map at the stated pose is `PLAIN_FIT` or
    more, or if fewer beams than a third of `COARSE_POINTS` have an echo.

    Args:
        field: likelihood field of the map.
        beams: beams of the scan.
        pose: map_T_base as it was stated, and corrected by the scan.
        noise: sigma of a point's distance to the map, in [m].
    """
    if not field.map.occupied.any():
        return StartFit(0.0)
    share = explained_share(field, beams, pose, noise)
    if share >= PLAIN_FIT or len(beams.points) < COARSE_POINTS // 3:
        return StartFit(share)
    found: list[tuple[float, Pose2]] = []
    points = beams.points
    for rough in _candidates(field, points):
        match = match_scan(field, points, rough, CANDIDATE_COVARIANCE, anneal=True)
        if not any(_same(match.pose, other) for _, other in found):
            found.append((explained_share(field, beams, match.pose, noise), match.pose))
    others = sorted(
        (pair for pair in found if not _same(pair[1], pose)), reverse=True, key=lambda pair: pair[0]
    )
    if not others:
        return StartFit(share)
    best, where = others[0]
    more = best - share
    if more <= MIN_SHARE_GAIN or (best < SURE_FIT and more <= MUCH_BETTER):
        return StartFit(share)
    alone = len(others) == 1 or others[1][0] < best - MIN_SHARE_GAIN
    is_sure = best >= SURE_FIT and alone and where.distance(pose) < PLAUSIBLE_M
    return StartFit(share, where, is_sure)


def map_ranges(field: LikelihoodField, sensor: Pose2, angles: FloatArray, reach: float) -> FloatArray:
    """Return the range (n,), in [m], at which each beam would meet a surface of the map; infinity beyond the
    reach.

    Args:
        field: likelihood field of the map.
        sensor: map_T_sensor.
        angles: (n,) angles of the beams relative to the sensor's heading, in [rad].
        reach: largest range, in [m].
    """
    grid = field.map
    return np.asarray(
        trace_ranges(
            field.distance,
            grid.occupied,
            (sensor.x - grid.origin_x) / grid.resolution - 0.5,
            (sensor.y - grid.origin_y) / grid.resolution - 0.5,
            np.ascontiguousarray(angles + sensor.theta),
            grid.resolution,
            reach,
        )
    )


def _same(one: Pose2, other: Pose2) -> bool:
    return one.distance(other) < NEAR_M and one.turn(other) < NEAR_RAD


def _candidates(field: LikelihoodField, points: FloatArray) -> list[Pose2]:
    """Poses all over the map from which the points lie near what it shows, the best first."""
    grid = field.map
    cells, _ = search_cells(field, HEADING_COUNT, MAX_POSES)
    some = np.ascontiguousarray(points[np.linspace(0, len(points) - 1, COARSE_POINTS).astype(np.int64)])
    turns = np.linspace(-math.pi, math.pi, HEADING_COUNT, endpoint=False)
    scores = score_poses(field.distance, cells, turns, some / grid.resolution, COARSE_M)
    order = np.argsort(scores, axis=None)[::-1][: 40 * MAX_CANDIDATES]
    found, headings = np.divmod(order, HEADING_COUNT)
    around = np.array([wrap(turn) for turn in turns.tolist()])
    poses = np.column_stack([grid.to_point(cells[found]), around[headings]])
    kept = spread_poses(poses, 2.0 * NEAR_M, 2.0 * NEAR_RAD, MAX_CANDIDATES)
    return [Pose2(*pose) for pose in poses[kept].tolist()]


@compiled
def spread_poses(poses: FloatArray, distance: float, turn: float, most: int) -> IntArray:
    """Return the indices of the first poses of which each is apart from all earlier ones that were chosen.

    Two poses are apart if their distance is at least `distance` or their turn at least `turn`.

    Args:
        poses: (n, 3) x, y in [m] and heading in [rad].
        distance: in [m].
        turn: in [rad].
        most: maximum number of poses.
    """
    kept, count = np.empty(most, dtype=np.int64), 0
    for i in range(len(poses)):
        if count == most:
            break
        is_apart = True
        for k in range(count):
            j = kept[k]
            away = math.hypot(poses[i, 0] - poses[j, 0], poses[i, 1] - poses[j, 1])
            if away < distance and abs(wrapped(poses[i, 2] - poses[j, 2])) < turn:
                is_apart = False
                break
        if is_apart:
            kept[count] = i
            count += 1
    return kept[:count]


def search_cells(field: LikelihoodField, headings: int, most: int) -> tuple[IntArray, float]:
    """Return free cells (n, 2), row and column, evenly distributed over a map, and the distance between them
    in [m].

    Cells are farther than `CLEAR_M` from surfaces.

    Args:
        field: likelihood field of the map.
        headings: number of headings that are tried at each cell.
        most: number of poses above which the cells are farther apart than `MIN_STRIDE_M`.
    """
    grid = field.map
    free = ~grid.occupied & (field.distance > CLEAR_M)
    area = float(free.sum()) * grid.resolution**2
    stride = max(MIN_STRIDE_M, math.sqrt(area * headings / most))
    every = max(1, round(stride / grid.resolution))
    return np.argwhere(free[::every, ::every]) * every, stride


@compiled
def score_poses(
    distance: SingleArray, cells: IntArray, turns: FloatArray, points: FloatArray, scale: float
) -> FloatArray:
    """Return scores (n, m) of a scan at poses in n cells with m headings: the higher, the nearer it is to
    surfaces.

    The score is a sum over the points of the scan. A point on a surface adds 1, a more distant point less,
    and a point farther than twice `scale` nothing.

    Args:
        distance: (h, w) of each cell to the nearest surface, in [m].
        cells: (n, 2) row and column of the base on the map.
        turns: (m,) headings on the map, in [rad].
        points: (k, 2) of the scan in the base frame, in [cells].
        scale: half the distance beyond which a point counts nothing, in [m].
    """
    height, width = distance.shape
    out = np.zeros((len(cells), len(turns)))
    for j in range(len(turns)):
        cos, sin = math.cos(turns[j]), math.sin(turns[j])
        for i in range(len(cells)):
            total = 0.0
            for k in range(len(points)):
                column = math.floor(cells[i, 1] + cos * points[k, 0] - sin * points[k, 1] + 0.5)
                row = math.floor(cells[i, 0] + sin * points[k, 0] + cos * points[k, 1] + 0.5)
                if 0 <= column < width and 0 <= row < height:
                    off = distance[row, column] / scale
                    if off < 2.0:
                        total += 1.0 - 0.25 * off * off
            out[i, j] = total
    return out


@compiled
def trace_ranges(
    distance: SingleArray,
    occupied: BoolArray,
    column: float,
    row: float,
    angles: FloatArray,
    resolution: float,
    reach: float,
) -> FloatArray:
    """Return the ranges (n,), in [m], at which beams from a place meet surfaces of a map; infinity beyond the
    reach.

    Args:
        distance: (h, w) of each cell to the nearest surface, in [m].
        occupied: (h, w) cells of the map.
        column: column of the place, a real number, cell centres at whole numbers.
        row: row of the place, a real number, cell centres at whole numbers.
        angles: (n,) directions of the beams on the map, in [rad].
        resolution: side of a cell, in [m].
        reach: largest range, in [m].
    """
    height, width = distance.shape
    out = np.empty(len(angles))
    for i in range(len(angles)):
        cos, sin, way = math.cos(angles[i]), math.sin(angles[i]), 0.0
        out[i] = np.inf
        while way * resolution < reach:
            x, y = column + way * cos, row + way * sin
            left, low = math.floor(x), math.floor(y)
            if not (0 <= left < width - 1 and 0 <= low < height - 1):
                break
            u, v = x - left, y - low
            near = distance[low, left] * (1 - u) + distance[low, left + 1] * u
            far = distance[low + 1, left] * (1 - u) + distance[low + 1, left + 1] * u
            cells = (near * (1 - v) + far * v) / resolution
            if cells < AT_SURFACE or (occupied[math.floor(y + 0.5), math.floor(x + 0.5)] and cells > 1.0):
                out[i] = way * resolution
                break
            way += max(0.5 * AT_SURFACE, 0.9 * (cells - 0.5 * AT_SURFACE))
    return out
