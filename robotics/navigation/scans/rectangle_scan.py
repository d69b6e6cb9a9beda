"""Pose of a rectangle of known size, such as a table that is solid down to the floor, in a lidar's scan.

Distance and turn are those of the lines through the sides that are seen. Along a front nothing but its ends
says where it is: which beams meet it and which pass (the beam model of Thrun, Burgard and Fox 2005, 6.3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.compiled import compiled

from .start_search import ScanBeams

GATE_M = 0.15  # from the expected outline, within which a point may be one of the rectangle
MAX_TURN_RAD = math.radians(12.0)  # from the expected heading
FIT_GATES_M = (0.15, 0.10, 0.06, 0.04, 0.04, 0.04)  # of the rounds of a fit of lines
SURFACE_SIGMA_M = 0.004  # of a real side's straightness, beside the lidar's noise
SHIFT_STEP_M = 0.002
SHIFT_SIGMAS = 3.0
MAX_BEAM_COST = 4.5  # of a beam that is not explained at all
HIDDEN_COST = 2.0  # of a beam that ends before the rectangle: something is in front of it
MIN_EXPLAINED = 12  # beams
MIN_EXPLAINED_SHARE = 0.5  # of the beams that should meet it
MAX_PASSING_SHARE = 0.15  # of them that go through it: a table on legs, or one that is elsewhere
MIN_SIGMA_M, MIN_SIGMA_RAD = 0.002, 0.002
ROUNDS = 2


class RectangleFit(NamedTuple):
    """Pose of a rectangular object that was fitted to lidar scans, with its covariance."""

    pose: Pose2
    """Pose of its middle in the base frame."""
    covariance: FloatArray
    """(3, 3) of x, y in [m] and heading in [rad], in the base frame; where nothing is seen, that of the
    prior.
    """
    explained: int
    """Number of beams that end on its sides."""


class _Rays(NamedTuple):
    """Beams from one place."""

    origin: FloatArray
    """(2,) in [m]."""
    directions: FloatArray
    """(n, 2) unit vectors."""
    ranges: FloatArray
    """(n,) in [m]; infinity without a return."""
    sigma: float
    """Standard deviation of a range, in [m]."""

    @property
    def points(self) -> FloatArray:
        """Points (m, 2) where beams ended, in [m]."""
        hit = np.isfinite(self.ranges)
        return np.asarray(self.origin + self.ranges[hit, None] * self.directions[hit])


def fit_rectangle(
    scans: Sequence[ScanBeams],
    size: tuple[float, float],
    expected: Pose2,
    covariance: FloatArray,
    sigma: float = 0.01,
) -> RectangleFit | None:
    """Return the pose of a rectangular object by lidar scans; None if it isn't seen near its expected pose.

    Args:
        scans: one or more scans from one pose of the base, outside the rectangle.
        size: size of the rectangle along its x and y, in [m].
        expected: expected pose of its middle in the base frame; the result is within `GATE_M` and
            `MAX_TURN_RAD` of it.
        covariance: (3, 3) of the expected pose, x, y in the base frame in [m] and heading in [rad].
        sigma: noise of a range, in [m].
    """
    rays = _averaged(scans, sigma)
    if rays is None or _is_inside(expected, size, rays.origin):
        return None
    found, prior = expected, np.asarray(covariance, dtype=np.float64)
    trust = np.asarray(np.linalg.inv(prior), dtype=np.float64)
    for _ in range(ROUNDS):
        lines = _fit_sides(rays.points, size, rays.origin, found, (expected, trust), rays.sigma)
        if lines is None:
            return None
        found, information, along = lines
        limit = math.sqrt(float(along @ prior[:2, :2] @ along))
        shift, variance = _shift_along(rays, size, found, along, limit)
        found = found._replace(x=found.x + shift * float(along[0]), y=found.y + shift * float(along[1]))
    away = found.distance(expected) > GATE_M or found.turn(expected) > MAX_TURN_RAD
    explained, passing, due = _counts(rays, size, found)
    if away or explained < max(MIN_EXPLAINED, MIN_EXPLAINED_SHARE * due) or passing > MAX_PASSING_SHARE * due:
        return None
    information[:2, :2] += np.outer(along, along) / variance
    least = np.diag([MIN_SIGMA_M, MIN_SIGMA_M, MIN_SIGMA_RAD]) ** 2
    return RectangleFit(found, np.asarray(np.linalg.inv(information)) + least, explained)


def _averaged(scans: Sequence[ScanBeams], sigma: float) -> _Rays | None:
    """Return the median of each beam over some scans, without blind beams."""
    alike = [scan for scan in scans if len(scan.ranges) == len(scans[0].ranges)]
    if not alike or not len(alike[0].ranges):
        return None
    stacked = np.stack([scan.ranges for scan in alike])
    known = (~np.isnan(stacked)).all(axis=0)
    ranges, angles = np.median(stacked[:, known], axis=0), alike[0].angles[known]
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    noise = math.hypot(1.25 * sigma / math.sqrt(len(alike)), SURFACE_SIGMA_M)  # of a median
    return _Rays(alike[0].origin, directions, ranges, noise)


def _is_inside(pose: Pose2, size: tuple[float, float], origin: FloatArray) -> bool:
    return bool((np.abs(pose.inverse().apply(origin[None])[0]) <= np.array(size) / 2).all())


def _fit_sides(
    points: FloatArray,
    size: tuple[float, float],
    origin: FloatArray,
    start: Pose2,
    prior: tuple[Pose2, FloatArray],
    sigma: float,
) -> tuple[Pose2, FloatArray, FloatArray] | None:
    """Fit the sides that face the sensor to points (n, 2); Gauss-Newton with Tukey's weights.

    Returns:
        The pose, the information (3, 3) of the points and the prior about it, and the direction (2,) along
        the side with most points; None with too few points.
    """
    pose, (expected, trust) = start, prior
    for gate in FIT_GATES_M:
        local = pose.inverse().apply(np.vstack([points, origin]))
        off, normals, near = _to_sides(local[:-1], local[-1], size, gate)
        if np.count_nonzero(near) < MIN_EXPLAINED:
            return None
        weights = (1.0 - (off[near] / gate) ** 2) ** 2 / sigma**2
        turned = Pose2(0.0, 0.0, pose.theta).apply(normals[near])
        away = points[near] - (pose.x, pose.y)
        levers = turned[:, 1] * away[:, 0] - turned[:, 0] * away[:, 1]
        rows = np.column_stack([turned, levers])
        information = (rows * weights[:, None]).T @ rows + trust
        short = np.array([expected.x - pose.x, expected.y - pose.y, _turn(expected, pose)])
        step = np.linalg.solve(information, rows.T @ (weights * off[near]) + trust @ short)
        pose = Pose2(pose.x + float(step[0]), pose.y + float(step[1]), pose.theta + float(step[2]))
    axes, counts = np.unique(np.round(normals[near]), axis=0, return_counts=True)
    front = Pose2(0.0, 0.0, pose.theta).apply(axes[int(np.argmax(counts))][None])[0]
    return pose, information, np.array([-front[1], front[0]])


def _turn(one: Pose2, other: Pose2) -> float:
    return math.remainder(one.theta - other.theta, 2.0 * math.pi)


def _to_sides(
    points: FloatArray, eye: FloatArray, size: tuple[float, float], gate: float
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return for points (n, 2) in a rectangle's frame how far they are outside of the nearest side that faces
    `eye`, that side's normal (n, 2), and whether they are within a gate of it.
    """
    half = np.array(size) / 2
    best, normals = np.full(len(points), np.inf), np.zeros((len(points), 2))
    for axis in (0, 1):
        sign = 1.0 if eye[axis] > 0.0 else -1.0
        if abs(eye[axis]) <= half[axis]:
            continue
        off = sign * points[:, axis] - half[axis]
        beyond = np.abs(points[:, 1 - axis]) - half[1 - axis]
        nearer = (np.abs(off) < np.abs(best)) & (beyond < gate)
        best[nearer] = off[nearer]
        normals[nearer] = np.eye(2)[axis] * sign
    return best, normals, np.abs(best) < gate


def _shift_along(
    rays: _Rays, size: tuple[float, float], pose: Pose2, along: FloatArray, limit: float
) -> tuple[float, float]:
    """Return the shift along a side that explains the beams best, in [m], and its variance in [m²].

    Args:
        rays: the beams.
        size: of the rectangle, in [m].
        pose: of the rectangle in the base frame.
        along: (2,) unit vector.
        limit: standard deviation of where it is expected, in [m].
    """
    reach = min(GATE_M, SHIFT_SIGMAS * limit)
    shifts = np.arange(-reach, reach + SHIFT_STEP_M / 2, SHIFT_STEP_M)
    due = _met_by_shift(rays, size, pose, shifts[:, None] * along)
    near = _to_sides(
        pose.inverse().apply(rays.origin + np.minimum(rays.ranges, 1e3)[:, None] * rays.directions),
        pose.inverse().apply(rays.origin[None])[0],
        size,
        GATE_M,
    )[2]
    cost = _costs(rays, due, near).sum(axis=1) + 0.5 * (shifts / limit) ** 2
    weights = np.exp(np.min(cost) - cost)
    weights /= weights.sum()
    shift = float(weights @ shifts)
    return shift, float(weights @ (shifts - shift) ** 2) + MIN_SIGMA_M**2


def _met(rays: _Rays, size: tuple[float, float], pose: Pose2) -> FloatArray:
    """Return the ranges (n,) at which beams meet a rectangle from outside, in [m]; infinity where they
    pass.
    """
    return np.asarray(_met_by_shift(rays, size, pose, np.zeros((1, 2)))[0])


def _met_by_shift(rays: _Rays, size: tuple[float, float], pose: Pose2, shifts: FloatArray) -> FloatArray:
    """Return the ranges (k, n) at which beams meet a rectangle that is shifted, in [m].

    A range is infinite where the beam passes.

    Args:
        rays: n beams, from outside the rectangle.
        size: lengths of the rectangle along its x and y, in [m].
        pose: pose of its middle before the shifts.
        shifts: (k, 2) along x and y of the frame in which `pose` is given, in [m].
    """
    back = Pose2(0.0, 0.0, wrap(-pose.theta))
    cos, sin = math.cos(pose.theta), math.sin(pose.theta)
    x, y = pose.x + shifts[:, 0], pose.y + shifts[:, 1]
    moved = np.column_stack([-cos * x - sin * y, sin * x - cos * y])
    origins = back.apply(rays.origin[None]) + moved
    return np.asarray(entry_ranges(origins, back.apply(rays.directions), np.array(size) / 2))


@compiled
def entry_ranges(origins: FloatArray, directions: FloatArray, half: FloatArray) -> FloatArray:
    """Return the ranges (k, n) at which beams enter a rectangle about the origin; infinity where they pass.

    Args:
        origins: (k, 2) places from which the beams start, outside the rectangle, in [m].
        directions: (n, 2) unit vectors of the beams, the same from each place.
        half: (2,) half lengths of the rectangle along x and y, in [m].
    """
    out = np.full((len(origins), len(directions)), np.inf)
    for k in range(len(origins)):
        for i in range(len(directions)):
            enters, leaves = -np.inf, np.inf
            for axis in range(2):
                slope = directions[i, axis] if abs(directions[i, axis]) >= 1e-12 else 1e-12
                first = (-half[axis] - origins[k, axis]) / slope
                second = (half[axis] - origins[k, axis]) / slope
                enters, leaves = max(enters, min(first, second)), min(leaves, max(first, second))
            if 0.0 < enters <= leaves:
                out[k, i] = enters
    return out


def _costs(rays: _Rays, due: FloatArray, near: BoolArray) -> FloatArray:
    """Return the costs of beams for ranges (..., n) at which they should end, in [m].

    Args:
        rays: beams.
        due: ranges at which they meet the rectangle.
        near: (n,) whether a beam ended near the rectangle.
    """
    meets = np.isfinite(due)
    off = np.where(meets, rays.ranges - np.where(meets, due, 0.0), 0.0)
    explained = np.minimum(0.5 * (off / rays.sigma) ** 2, MAX_BEAM_COST)
    hidden = off < -3.0 * rays.sigma
    unexplained = np.where(near & np.isfinite(rays.ranges), MAX_BEAM_COST, 0.0)
    return np.where(meets, np.where(hidden, HIDDEN_COST, explained), unexplained)


def _counts(rays: _Rays, size: tuple[float, float], pose: Pose2) -> tuple[int, int, int]:
    """Return how many beams end on a rectangle, go through it, and should meet it."""
    due = _met(rays, size, pose)
    meets = np.isfinite(due)
    off = rays.ranges[meets] - due[meets]
    limit = max(0.02, 3.0 * rays.sigma)
    return int((np.abs(off) < limit).sum()), int((off > limit).sum()), int(meets.sum())
