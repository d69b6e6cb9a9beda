"""Recognition of solids of known sizes in a group of points on a surface, with their poses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from scipy.optimize import least_squares

from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.numerics.arrays import FloatArray

from .outline_fit import INSET_PX, INSET_SIGMA_PX, OutlineFit, distances, fit_outline
from .standing_clusters import MIN_HEIGHT_M, PointCluster

HEIGHT_SIGMA_M = 0.001  # of an upper side over the plane that was seen
HEIGHT_TOLERANCE_M = 0.0035  # of an upper side
MAX_RMS_CELLS, MAX_RMS_M = 0.8, 0.001  # of an outline's points, in cells and beside them
MAX_INSET_PX, MIN_INSET_PX = 4.5, -1.0  # of an outline
MIN_COVERAGE = 0.45  # of an outline
BEYOND_M = 0.008  # outside of an outline
MAX_BEYOND_SHARE = 0.02  # of a group's points that may be there
SAME_SIZE_M = 0.001  # maximum difference of sides that count as equal
INNER_M = 0.005  # inside of an outline, where no side is seen
MIN_SAG_POINTS = 10  # fewer tell nothing of an upper side's form, as of one narrower than twice INNER_M
MAX_SAG_M = 0.0015  # of a flat upper side, from its middle to its edge
LYING_HEIGHT_TOLERANCE_M = 0.006  # likewise, of what is seen of a round one
LYING_RMS_M = 0.0014  # of points on the side of a lying cylinder
LYING_LENGTH_TOLERANCE_M = 0.012
LYING_MIN_POINTS = 30
LYING_MIN_SHARE = 0.8  # of the points over the axis that are on the side
LYING_BAND_M = 0.003  # from the side


class KnownSolid(NamedTuple):
    """A box, or a cylinder along z, of known size."""

    name: str
    size: tuple[float, float, float]
    """Size along x, y and z, in [m]."""
    is_round: bool = False


class SolidCandidate(NamedTuple):
    """Known solid that a group of measured points may belong to, with the pose that fits best."""

    name: str
    surface_T_solid: Transform
    """Pose (4, 4) of an upright solid, whose origin is in the middle of its foot.

    A fallen box has its origin on the surface below its middle, z up, and x along the first of its level
    sides (in the order x, y, z); a lying cylinder has it in its middle, z along its axis.
    """
    covariance: FloatArray
    """(3, 3) of x, y in [m] and heading in [rad] on the surface."""
    is_upright: bool
    rms: float
    """Root mean square of the residuals, in [m]."""


def candidates(cluster: PointCluster, known: Sequence[KnownSolid]) -> list[SolidCandidate]:
    """Return all known solids that a group of points may belong to, upright or fallen, each at most once.

    A solid fits if the height and the outline of its upper side agree with the group's points, and none of
    them is outside it. So points of two solids that touch each other fit no solid.

    Args:
        cluster: measured points that lie close together, as one group.
        known: known solids.
    """
    found = []
    for solid in known:
        for item in (_round if solid.is_round else _boxed)(cluster, solid):
            found.append(item)
            if item.is_upright:
                break
    return found


def _boxed(cluster: PointCluster, solid: KnownSolid) -> Iterator[SolidCandidate]:
    """Yield the box on each of its different sides, upright first."""
    x, y, z = solid.size
    tried: list[tuple[float, tuple[float, float]]] = []
    for height, sides in ((z, (x, y)), (x, (y, z)), (y, (x, z))):
        alike = any(
            abs(height - other) < SAME_SIZE_M and np.allclose(sorted(sides), sorted(others), atol=SAME_SIZE_M)
            for other, others in tried
        )
        tried.append((height, sides))
        if alike or abs(cluster.top - height) > HEIGHT_TOLERANCE_M:
            continue
        fit = _fitting(cluster, sides)
        if fit is not None:
            yield _candidate(solid, fit, cluster, len(tried) == 1)


def _round(cluster: PointCluster, solid: KnownSolid) -> Iterator[SolidCandidate]:
    """Yield the cylinder upright, and lying."""
    diameter, _, height = solid.size
    if abs(cluster.top - height) <= HEIGHT_TOLERANCE_M:
        fit = _fitting(cluster, diameter)
        if fit is not None:
            yield _candidate(solid, fit, cluster, True)
    if abs(cluster.top - diameter) <= LYING_HEIGHT_TOLERANCE_M:
        lying = _lying(cluster, diameter / 2, height)
        if lying is not None:
            yield SolidCandidate(solid.name, *lying[:2], False, lying[2])


def _fitting(cluster: PointCluster, sides: tuple[float, float] | float) -> OutlineFit | None:
    """Return the pose of an upper side; None if it isn't one of that size."""
    fit = fit_outline(cluster.outline, sides, cluster.cell, cluster.pixel)
    if fit is None or fit.rms > MAX_RMS_CELLS * cluster.cell + MAX_RMS_M or fit.coverage < MIN_COVERAGE:
        return None
    if not MIN_INSET_PX <= fit.inset / cluster.pixel <= MAX_INSET_PX:
        return None
    away = distances(cluster.points[:, :2], sides, fit.x, fit.y, fit.heading)
    if (
        float((away > BEYOND_M).mean()) > MAX_BEYOND_SHARE
        or _sag(cluster.points[away < -INNER_M], fit) > MAX_SAG_M
    ):
        return None
    return fit


def _sag(points: FloatArray, fit: OutlineFit) -> float:
    """Return how much lower the edges of an upper side are than its middle, in [m]; 0 if too few points tell.

    Args:
        points: (n, 3) within its outline, in [m].
        fit: its outline.
    """
    if len(points) < MIN_SAG_POINTS:
        return 0.0
    points = points[points[:, 2] > np.median(points[:, 2]) - 3.0 * LYING_HEIGHT_TOLERANCE_M]
    off = points[:, :2] - (fit.x, fit.y)
    cos, sin = math.cos(fit.heading), math.sin(fit.heading)
    local = np.column_stack([cos * off[:, 0] + sin * off[:, 1], cos * off[:, 1] - sin * off[:, 0]])
    half = np.abs(local).max(axis=0)
    A = np.column_stack([np.ones(len(local)), local, (local / half) ** 2])
    found = np.linalg.lstsq(A, points[:, 2], rcond=None)[0]
    return float(np.abs(found[3:]).max())


def _candidate(solid: KnownSolid, fit: OutlineFit, cluster: PointCluster, is_upright: bool) -> SolidCandidate:
    """Return a fit as a candidate, shifted and with more variance along the line of sight.

    In a slanted view readings are missing at the far edge, which is a step in depth, and not at the near
    one, where a side begins: the upper side seems nearer to the camera by half of what is missing. A wrong
    height moves it along the line of sight.
    """
    away = np.array([fit.x, fit.y]) - cluster.eye[:2]
    length = float(np.linalg.norm(away))
    covariance = fit.covariance.copy()
    slope = away / max(cluster.eye[2] - cluster.top, MIN_HEIGHT_M)
    covariance[:2, :2] += HEIGHT_SIGMA_M**2 * np.outer(slope, slope)
    shift = np.zeros(2)
    edge = 0.5 * cluster.pixel * math.hypot(1.0, float(np.linalg.norm(slope)))
    if not solid.is_round:  # more may be missing at one end of an edge than at the other
        covariance[2, 2] += (INSET_SIGMA_PX * edge / max(solid.size[:2])) ** 2
    if length > min(solid.size) / 2:
        sight = away / length
        shift = INSET_PX * edge * sight
        covariance[:2, :2] += (INSET_SIGMA_PX * edge) ** 2 * np.outer(sight, sight)
    place = (fit.x + float(shift[0]), fit.y + float(shift[1]), 0.0)
    pose = transform(place, (0.0, 0.0, fit.heading))
    return SolidCandidate(solid.name, pose, covariance, is_upright, fit.rms)


def _lying(cluster: PointCluster, radius: float, length: float) -> tuple[Transform, FloatArray, float] | None:
    """Return pose (4, 4), covariance (3, 3) and residual of a lying cylinder; None if it isn't one.

    The distances of the points from the axis are fitted; those of its ends are outliers.
    """
    every = cluster.points[cluster.points[:, 2] > max(MIN_HEIGHT_M, radius)]
    if len(every) < LYING_MIN_POINTS:
        return None
    middle = every[:, :2].mean(axis=0)
    (_, _), _, degrees = cv2.minAreaRect(every[:, :2].astype(np.float32))
    fits = [
        least_squares(
            lambda state: _off_axis(every, middle, state, radius),
            np.array([0.0, math.radians(degrees + turn)]),
            loss="huber",
            f_scale=LYING_BAND_M,
        )
        for turn in (0.0, 90.0)
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    aside, heading = best.x.tolist()
    residuals = _off_axis(every, middle, best.x, radius)
    near = np.abs(residuals) < LYING_BAND_M
    if near.mean() < LYING_MIN_SHARE:
        return None
    rms = float(np.sqrt(np.mean(residuals[near] ** 2)))
    ahead = np.array([math.cos(heading), math.sin(heading)])
    along = (every[near, :2] - middle) @ ahead
    ends = float(along.min()), float(along.max())
    short = length - (ends[1] - ends[0])
    if rms > LYING_RMS_M or not -LYING_LENGTH_TOLERANCE_M / 2 < short < LYING_LENGTH_TOLERANCE_M:
        return None
    x, y = (middle + (ends[0] + ends[1]) / 2 * ahead + aside * np.array([-ahead[1], ahead[0]])).tolist()
    across, turned = np.diag(np.linalg.pinv(best.jac.T @ best.jac)) * rms**2
    turn = np.array([[ahead[0], -ahead[1]], [ahead[1], ahead[0]]])
    covariance = np.diag([0.0, 0.0, float(turned)])
    covariance[:2, :2] = turn @ np.diag([short**2 / 12, float(across)]) @ turn.T
    return transform((x, y, radius), (0.0, math.pi / 2, heading)), covariance, rms


def _off_axis(points: FloatArray, middle: FloatArray, state: FloatArray, radius: float) -> FloatArray:
    """Return the distances (n,) of points (n, 3) from the side of a lying cylinder, in [m].

    Args:
        points: in [m].
        middle: (2,) of all points, in [m].
        state: (2,): offset of the axis from there to the left in [m], and its heading in [rad].
        radius: in [m].
    """
    across = (points[:, :2] - middle) @ (-math.sin(state[1]), math.cos(state[1])) - state[0]
    return np.asarray(np.hypot(across, points[:, 2] - radius) - radius)
