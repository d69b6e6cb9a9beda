"""Fit of a rectangle or a circle of known size to points around it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MAX_STEPS = 15
DERIVATIVE_STEPS = np.array([1e-5, 1e-5, 1e-4, 1e-5])  # of the derivatives, in [m], [m], [rad], [m]
SUFFICIENT_STEP = 1e-7
HUBER_SIGMAS = 2.0
INSET_PX, INSET_SIGMA_PX = 1.5, 2.5  # by which readings are missing along an edge
CELL_SIGMA = 0.5  # of a point across the outline, in cells
SHORTER_M = 0.008  # by which a patch must be shorter than its side to be a part of it
RIVAL_RATIO = 1.25  # of the residuals of two fits, up to which either may be true
RIVAL_APART_M = 0.012
OUTLINE_SAMPLE_COUNT = 72  # along the outline, for its coverage


class OutlineFit(NamedTuple):
    """Pose of a rectangle or circle that was fitted to points, in the frame of the points, with its
    accuracy.
    """

    x: float
    """Position of the outline's middle along x, in [m]."""
    y: float
    """Position of the outline's middle along y, in [m]."""
    heading: float
    """Heading of its first side in [rad]; 0 for a circle."""
    inset: float
    """Distance of the points inwards from the outline, in [m]."""
    covariance: FloatArray
    """(3, 3) of x, y in [m] and heading in [rad], as above; a circle's heading has a very large variance."""
    rms: float
    """Root mean square of the residuals, in [m]."""
    coverage: float
    """Share of the outline with points near it."""


def fit_outline(
    points: FloatArray, sides: tuple[float, float] | float, cell: float, pixel: float
) -> OutlineFit | None:
    """Fit an outline of known size to points; return None if its pose isn't determined.

    The fit is a least-squares fit (Gauss and Newton) with Huber's weights, which limit the effect of
    outliers. A depth camera has no readings in a strip next to a step in depth. The width of the strip is
    fitted too; it is assumed to be the same all around the outline.

    Args:
        points: (n, 2) on the outline or a part of it, in any plane frame, in [m]; the pose is in that frame.
        sides: lengths of a rectangle, or the diameter of a circle, in [m].
        cell: distance of neighbouring points, in [m].
        pixel: distance of neighbouring pixels of the depth camera on the object, in [m].
    """
    if len(points) < 12:
        return None
    fits = [_refined(points, sides, start, cell, pixel) for start in _starts(points, sides)]
    fits.sort(key=lambda fit: fit.rms)
    best = fits[0]
    for other in fits[1:]:
        apart = math.hypot(other.x - best.x, other.y - best.y)
        if apart > RIVAL_APART_M and other.rms < RIVAL_RATIO * best.rms:
            return None
    return best


def distances(
    points: FloatArray,
    sides: tuple[float, float] | float,
    x: float,
    y: float,
    heading: float,
    inset: float = 0.0,
) -> FloatArray:
    """Return the signed distances (n,) of points from a rectangle or a circle, in [m]; negative inside.

    Args:
        points: (n, 2) points in any plane frame, in [m].
        sides: lengths of the rectangle, or the diameter of the circle, in [m].
        x: position of the outline's middle in that frame, in [m].
        y: position of the outline's middle in that frame, in [m].
        heading: direction of the rectangle's first side, in [rad]; ignored for a circle.
        inset: distance by which the outline is moved inwards on each side, in [m].
    """
    off = points - (x, y)
    if isinstance(sides, float):
        return np.asarray(np.hypot(off[:, 0], off[:, 1]) - (sides / 2 - inset))
    cos, sin = math.cos(heading), math.sin(heading)
    local = np.abs(np.column_stack([cos * off[:, 0] + sin * off[:, 1], cos * off[:, 1] - sin * off[:, 0]]))
    beyond = local - (np.array(sides) / 2 - inset)
    outside = np.hypot(*np.maximum(beyond, 0.0).T)
    return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0))


def _starts(points: FloatArray, sides: tuple[float, float] | float) -> Iterator[FloatArray]:
    """Yield first guesses (4,): x, y, heading, inset; where a part is seen, from both ends of it."""
    (x, y), (width, height), degrees = cv2.minAreaRect(points.astype(np.float32))
    if isinstance(sides, float):
        yield np.array([x, y, 0.0, 0.0])
        middle = points.mean(axis=0)
        yield np.array([2 * x - middle[0], 2 * y - middle[1], 0.0, 0.0])
        return
    for turn, seen in ((0.0, (width, height)), (90.0, (height, width))):
        heading = math.radians(degrees + turn)
        missing = [max(0.0, side - item - SHORTER_M) for side, item in zip(sides, seen, strict=True)]
        ahead = np.array([math.cos(heading), math.sin(heading)])
        aside = np.array([-ahead[1], ahead[0]])
        for i in (1.0, -1.0) if missing[0] > 0.0 else (0.0,):
            for k in (1.0, -1.0) if missing[1] > 0.0 else (0.0,):
                middle = np.array([x, y]) + (i * missing[0] * ahead + k * missing[1] * aside) / 2
                yield np.array([*middle, heading, 0.0])


def _refined(
    points: FloatArray, sides: tuple[float, float] | float, start: FloatArray, cell: float, pixel: float
) -> OutlineFit:
    state, sigma, is_circle = start.copy(), CELL_SIGMA * cell, isinstance(sides, float)
    mean, spread = INSET_PX * pixel, INSET_SIGMA_PX * pixel
    J, weights, residuals = np.zeros((1, 4)), np.ones(1), np.zeros(1)
    for _ in range(MAX_STEPS):
        residuals = distances(points, sides, *state.tolist())
        J = np.column_stack(
            [
                (distances(points, sides, *(state + step).tolist()) - residuals) / step[i]
                for i, step in enumerate(np.diag(DERIVATIVE_STEPS))
            ]
        )
        scaled = np.abs(residuals) / sigma
        weights = 1.0 / np.maximum(1.0, scaled / HUBER_SIGMAS)
        A, right = _normal(J, residuals, weights, sigma, (state[3] - mean) / spread, spread, is_circle)
        change = np.linalg.lstsq(A, -right, rcond=None)[0]
        state = state + change
        if float(np.abs(change).max()) < SUFFICIENT_STEP:
            break
    A, _ = _normal(J, residuals, weights, sigma, 0.0, spread, is_circle)
    rms = float(np.sqrt(np.mean(residuals**2)))
    covariance = np.asarray(np.linalg.pinv(A)[:3, :3]) * max(1.0, (rms / sigma) ** 2)
    if is_circle:
        state[2], covariance[2, 2] = 0.0, math.pi**2
    x, y, heading, inset = state.tolist()
    return OutlineFit(
        x, y, heading, inset, covariance, rms, _coverage(points, sides, (x, y, heading), inset, cell)
    )


def _normal(
    J: FloatArray,
    residuals: FloatArray,
    weights: FloatArray,
    sigma: float,
    off: float,
    spread: float,
    is_circle: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return the normal equations (4, 4) and their right side (4,), with the prior of the inset."""
    A = (J * weights[:, None]).T @ J / sigma**2
    right = (J * weights[:, None]).T @ residuals / sigma**2
    A[3, 3] += 1.0 / spread**2
    right[3] += off / spread
    if is_circle:
        A[2, 2] += 1.0
    return A, right


def _coverage(
    points: FloatArray,
    sides: tuple[float, float] | float,
    pose: tuple[float, float, float],
    inset: float,
    cell: float,
) -> float:
    x, y, heading = pose
    if isinstance(sides, float):
        angles = np.arange(OUTLINE_SAMPLE_COUNT) * (2.0 * math.pi / OUTLINE_SAMPLE_COUNT)
        around = (sides / 2 - inset) * np.column_stack([np.cos(angles), np.sin(angles)])
    else:
        a, b = (side / 2 - inset for side in sides)
        corners = np.array([(a, b), (-a, b), (-a, -b), (a, -b), (a, b)])
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        along = np.arange(OUTLINE_SAMPLE_COUNT) * (lengths[-1] / OUTLINE_SAMPLE_COUNT)
        around = np.column_stack([np.interp(along, lengths, corners[:, i]) for i in (0, 1)])
    cos, sin = math.cos(heading), math.sin(heading)
    around = around @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
    away = np.linalg.norm(around[:, None] - points[None], axis=2).min(axis=1)
    return float((away < 3.0 * cell).mean())
