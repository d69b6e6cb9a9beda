"""Arc or line that a handle follows, fitted to measured points of its path."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

OFFSET, HEADING, CURVATURE, HEIGHT, SLOPE_X, SLOPE_Y = range(6)
STRAIGHT_SIGMAS = 4.0  # of the curvature, below which a path may be straight
STRAIGHT_CURVATURE = 0.2  # [1/m]: a path with certainly less is taken as straight
MIN_CURVATURE = 1e-9  # [1/m]
MIN_ROOT = 1e-9  # under the square root, of points beyond the middle of a circle


class PathPrior(NamedTuple):
    """Expected path of a handle before it was measured, with uncertainties."""

    heading: float
    """Direction at the start, in [rad] from x of the points' frame, about z."""
    heading_sigma: float
    """Standard deviation of the heading, in [rad]."""
    curvature: float
    """Curvature at the start, in [1/m], positive to the left."""
    curvature_sigma: float
    """Standard deviation of the curvature, in [1/m]."""
    slope_sigma: float
    """Standard deviation of the slope of the path's plane, along each level axis, without unit."""


class HingeFit(NamedTuple):
    """Axis about which a handle turns as its door opens, with uncertainty, estimated from points of its
    path.
    """

    point: FloatArray
    """Point (3,) where the axis meets the plane of the path, in the frame of the fitted points, in [m]."""
    covariance: FloatArray
    """Covariance (2, 2) of the point's x and y, in [m²]."""
    radius: float
    """Distance of the path from the axis, in [m]."""
    radius_sigma: float
    """Standard deviation of the radius, in [m]."""
    axis: FloatArray
    """Unit vector (3,) along the axis, upwards, in the frame of the fitted points."""
    axis_sigma: float
    """Standard deviation of the axis' tilt in the worse direction, in [rad]."""


class PathFit(NamedTuple):
    """Path fitted to points of a handle, an arc or a line in a plane that is level or slopes a little.

    Everything is in the frame of the fitted points, z up. The six numbers of `state` are: offset of the path
    to the left of `origin` in [m]; heading of the path next to `origin` in [rad]; curvature in [1/m]; height
    above `origin` in [m]; slopes of the plane along x and y, without unit.
    """

    origin: FloatArray
    """(3,) first point, in [m]."""
    state: FloatArray
    covariance: FloatArray
    """Covariance (6, 6) of `state`, in its order and units."""
    rms: float
    """Root mean square of the points' distances from the path, in [m]."""

    @property
    def curvature(self) -> float:
        """Curvature of the path in [1/m], positive if the path bends to the left."""
        return float(self.state[CURVATURE])

    @property
    def curvature_sigma(self) -> float:
        """Standard deviation of the path's curvature, in [1/m]."""
        return math.sqrt(self.covariance[CURVATURE, CURVATURE])

    @property
    def is_curved(self) -> bool | None:
        """True for an arc, False for a line, None if the points fit both."""
        size, sigma = abs(self.curvature), self.curvature_sigma
        if size > STRAIGHT_SIGMAS * sigma:
            return size > STRAIGHT_CURVATURE
        return False if size + STRAIGHT_SIGMAS * sigma < STRAIGHT_CURVATURE else None

    def turned(self, point: FloatArray) -> float:
        """Return the path's turn in [rad], left positive, from its start to its point nearest to a point
        (3,), in [m] in the frame of the fitted points.
        """
        u, v = _along_and_aside((point - self.origin)[None], self.state)
        return math.atan2(self.curvature * float(u[0]), 1.0 - self.curvature * float(v[0]))

    def travel(self, point: FloatArray) -> float:
        """Return the length, in [m], of the path from its start to its point nearest to a point (3,), in [m]
        in the frame of the fitted points.
        """
        if abs(self.curvature) < MIN_CURVATURE:
            return float(_along_and_aside((point - self.origin)[None], self.state)[0][0])
        return self.turned(point) / self.curvature

    def tangent(self, point: FloatArray) -> FloatArray:
        """Return the unit vector (3,) along the fitted path at its nearest point to a given point (3,) in
        [m].

        Both are in the frame of the points to which the path was fitted.
        """
        heading = float(self.state[HEADING]) + self.turned(point)
        level = np.array([math.cos(heading), math.sin(heading)])
        way = np.append(level, level @ self.state[SLOPE_X:])
        return np.asarray(way / np.linalg.norm(way))

    def hinge(self) -> HingeFit:
        """Return the axis of the arc, with the uncertainty that follows from the fit's covariance.

        Raises:
            ZeroDivisionError: the path is straight.
        """
        offset, heading, curvature = self.state[:3].tolist()
        aside = np.array([-math.sin(heading), math.cos(heading)])
        reach = offset + 1.0 / curvature
        middle = reach * aside
        J = np.column_stack(
            [aside, -reach * np.array([math.cos(heading), math.sin(heading)]), -aside / curvature**2]
        )
        normal = np.append(-self.state[SLOPE_X:], 1.0)
        height = float(self.state[HEIGHT] + middle @ self.state[SLOPE_X:])
        slopes = np.linalg.eigvalsh(self.covariance[SLOPE_X:, SLOPE_X:])
        return HingeFit(
            self.origin + np.append(middle, height),
            np.asarray(J @ self.covariance[:3, :3] @ J.T),
            1.0 / abs(curvature),
            self.curvature_sigma / curvature**2,
            np.asarray(normal / np.linalg.norm(normal)),
            math.sqrt(float(slopes.max())),
        )


def fit_path(points: FloatArray, sigma: float, prior: PathPrior) -> PathFit:
    """Fit an arc or a line to points of a handle's path, by least squares of the distances.

    The parameters are those of Karimäki (1991), "Effective circle fitting for particle trajectories", eq. 1:
    they have no singularity for a straight line, so the same fit is used for hinges and slides.

    Args:
        points: (n, 3) measured points in the order of the motion, in any frame with z up, in [m]; at least
            one.
        sigma: standard deviation of each coordinate, in [m]; errors of different points are independent.
        prior: expected path, which is used like additional measurements.
    """
    from scipy.optimize import least_squares

    origin = np.array(points[0], dtype=np.float64)
    around = np.asarray(points - origin, dtype=np.float64)
    start = np.array([0.0, prior.heading, prior.curvature, 0.0, 0.0, 0.0])

    def residuals(state: FloatArray) -> FloatArray:
        return np.concatenate([_distances(around, state).ravel() / sigma, _off_belief(state, prior)])

    found = least_squares(residuals, start, method="lm")
    information = found.jac.T @ found.jac
    distances = _distances(around, found.x)
    rms = float(np.sqrt(np.mean(np.sum(distances**2, axis=1))))
    return PathFit(origin, np.asarray(found.x), np.asarray(np.linalg.pinv(information)), rms)


def _distances(around: FloatArray, state: FloatArray) -> FloatArray:
    """Return the distances (n, 2) of points (n, 3) from the path, in its plane and out of it, in [m]."""
    u, v = _along_and_aside(around, state)
    curvature = float(state[CURVATURE])
    power = v - 0.5 * curvature * (u**2 + v**2)
    root = np.sqrt(np.maximum(1.0 - 2.0 * curvature * power, MIN_ROOT))
    aside = 2.0 * power / (1.0 + root)  # Karimäki (1991), eq. 2, without its approximation
    return np.column_stack([aside, around[:, 2] - state[HEIGHT] - around[:, :2] @ state[SLOPE_X:]])


def _along_and_aside(around: FloatArray, state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the coordinates (n,) of points along the heading of the start and to its left, in [m]."""
    cos, sin = math.cos(state[HEADING]), math.sin(state[HEADING])
    return (
        cos * around[:, 0] + sin * around[:, 1],
        -sin * around[:, 0] + cos * around[:, 1] - float(state[OFFSET]),
    )


def _off_belief(state: FloatArray, prior: PathPrior) -> FloatArray:
    """Return the residuals (4,) of the belief, in standard deviations."""
    return np.array(
        [
            math.remainder(state[HEADING] - prior.heading, 2.0 * math.pi) / prior.heading_sigma,
            (state[CURVATURE] - prior.curvature) / prior.curvature_sigma,
            state[SLOPE_X] / prior.slope_sigma,
            state[SLOPE_Y] / prior.slope_sigma,
        ]
    )
