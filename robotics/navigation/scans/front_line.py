"""Docking on a straight front: the line of a shelf's front, seen by a lidar."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray

MIN_LINE_POINTS = 12  # points: fewer don't make a line
FIT_ITERATIONS = 8
SEED_POINT_COUNT = 24  # points whose pairs are tried as a first line
# sigmas beyond which a point counts nothing: a thing 50 mm before the front must not tilt it
TUKEY_SIGMAS = 3.5


class FrontLine(NamedTuple):
    """Straight front of an object, as a line fitted to lidar points, in the base frame."""

    distance: float
    """Perpendicular distance from the base's origin to the line, in [m]."""
    angle: float
    """Direction of the line's nearest point (of the front's inward normal), in [rad]; 0: square before it."""
    distance_std: float
    """Standard deviation of the distance, in [m]."""
    angle_std: float
    """Standard deviation of the angle, in [rad]."""
    inliers: int
    """Number of points on the line."""


def fit_front(
    points: FloatArray,
    expected: FloatArray,
    sigma: float = 0.01,
    gate: float = 0.1,
    margin: float = 0.05,
) -> FrontLine | None:
    """Fit a line to scan points of a straight front.

    The best line through two of the points is improved by least squares with Tukey's weights, which are 0 for
    points far off the line. So obstacles in front of a part of the front, and openings in it, do not displace
    the line.

    Args:
        points: (n, 2) scan points in the base frame, in [m]; several scans from one pose may be stacked.
        expected: (2, 2) the front's two ends in the base frame, by map and pose, in [m].
        sigma: noise of a range, in [m].
        gate: largest distance of the front from its expected position, in [m].
        margin: length ignored at both ends of the front, in [m]; corners belong to other things as well.

    Returns:
        The line; None if too few points belong to one line.
    """
    along, normal = _axes(expected)
    local = np.column_stack([(points - expected[0]) @ along, (points - expected[0]) @ normal])
    length = float(np.linalg.norm(expected[1] - expected[0]))
    chosen = points[(np.abs(local[:, 1]) < gate) & (local[:, 0] > margin) & (local[:, 0] < length - margin)]
    if len(chosen) < MIN_LINE_POINTS:
        return None
    centre, normal = _first_line(chosen, along, normal, sigma)
    for _ in range(FIT_ITERATIONS):
        ratio = (chosen - centre) @ normal / (TUKEY_SIGMAS * sigma)
        weights = np.where(np.abs(ratio) < 1.0, (1.0 - ratio**2) ** 2, 0.0)
        if np.count_nonzero(weights) < MIN_LINE_POINTS:
            return None
        centre, normal = _weighted_line(chosen, weights, normal)
    return _front(chosen, weights, centre, normal, sigma)


def _axes(segment: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors (2,) along a segment (2, 2) and across it, the latter away from the origin."""
    along = (segment[1] - segment[0]) / np.linalg.norm(segment[1] - segment[0])
    normal = np.array([-along[1], along[0]])
    return along, normal if normal @ segment[0] >= 0.0 else -normal


def _first_line(
    points: FloatArray, along: FloatArray, normal: FloatArray, sigma: float
) -> tuple[FloatArray, FloatArray]:
    """Return a point (2,) and the normal (2,) of the line that explains most of the points (MSAC).

    Lines through two far points are tried.
    """
    ordered = points[np.argsort(points @ along, kind="stable")]
    some = ordered[np.linspace(0, len(points) - 1, min(SEED_POINT_COUNT, len(points))).astype(np.int64)]
    first, second = np.triu_indices(len(some), k=max(1, len(some) // 4))
    rays = some[second] - some[first]
    normals = np.column_stack([-rays[:, 1], rays[:, 0]]) / np.maximum(np.hypot(*rays.T), 1e-9)[:, None]
    normals[normals @ normal < 0.0] *= -1.0
    off = normals @ points.T - (normals * some[first]).sum(axis=1)[:, None]
    best = int(np.argmin(np.minimum((off / (1.5 * sigma)) ** 2, 1.0).sum(axis=1)))
    return some[first[best]], normals[best]


def _weighted_line(
    points: FloatArray, weights: FloatArray, towards: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return centre (2,) of points (n, 2) and normal (2,), towards `towards`, of the line through them."""
    centre: FloatArray = weights @ points / weights.sum()
    off = points - centre
    _, axes = np.linalg.eigh((off * weights[:, None]).T @ off)
    normal = axes[:, 0] if axes[:, 0] @ towards >= 0.0 else -axes[:, 0]
    return centre, normal


def _front(
    points: FloatArray,
    weights: FloatArray,
    centre: FloatArray,
    normal: FloatArray,
    sigma: float,
) -> FrontLine:
    used = weights > 0.0
    at = (points - centre) @ np.array([-normal[1], normal[0]])
    spread = float((weights * at**2).sum())
    noise = max(sigma, float(np.std(((points - centre) @ normal)[used])))
    angle_std = noise / math.sqrt(spread)
    lever = float(
        centre @ np.array([-normal[1], normal[0]])
    )  # of the foot point, seen from the points' centre
    distance_std = math.hypot(noise / math.sqrt(float(weights.sum())), lever * angle_std)
    angle = math.atan2(float(normal[1]), float(normal[0]))
    return FrontLine(float(centre @ normal), angle, distance_std, angle_std, int(used.sum()))


def pose_from_front(pose: Pose2, front: FrontLine, segment: FloatArray) -> Pose2:
    """Correct a pose by a measured straight front of an object: the heading, and the position along the
    front's normal.

    Args:
        pose: map_T_base, accurate enough that the front is not confused with another one.
        front: front as fitted to a scan, in the base frame.
        segment: (2, 2) the front's two ends on the map, in [m].
    """
    along = (segment[1] - segment[0]) / np.linalg.norm(segment[1] - segment[0])
    here = np.array([pose.x, pose.y])
    normal = np.array([-along[1], along[0]])
    normal = normal if normal @ (segment[0] - here) >= 0.0 else -normal
    heading = wrap(math.atan2(float(normal[1]), float(normal[0])) - front.angle)
    moved = here + (float(normal @ (segment[0] - here)) - front.distance) * normal
    return Pose2(float(moved[0]), float(moved[1]), heading)
