"""Clusters of a scan's points that may be a person or a cart."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

BREAK_M = 0.13  # between neighbouring points of different bodies
PAIR_DISTANCE_M = 0.6  # between the outermost pieces of one body, such as two legs
MAX_EXTENT_M = 1.2  # of a person, a pram or a cart
MIN_POINTS = 2  # of a leg, with a beam a degree; a lone one is noise
DEPTH_SHARE = 0.32  # of a round body's width, from the mean of its visible points to its middle


class ScanClusters(NamedTuple):
    """Groups of scan points that have the size of a person or a cart."""

    centres: FloatArray
    """(k, 2) estimated middles, in the frame of the points, in [m]."""
    radii: FloatArray
    """(k,) from the middle to the outermost point, in [m]."""
    labels: IntArray
    """(n,) index of the body of each point; -1 for points of no such body."""


def cluster_scan(points: FloatArray, sensor: FloatArray) -> ScanClusters:
    """Group the points of a scan into bodies.

    Neighbouring points closer than `BREAK_M` are joined to pieces. Pieces are joined to a body if all their
    distances are below `PAIR_DISTANCE_M` (complete linkage). So two legs become one person, while two persons
    side by side stay separate.

    Args:
        points: (n, 2) points of the scan in the order of their beams, in any one frame, in [m].
        sensor: (2,) position of the lidar in the same frame, in [m].
    """
    pieces, middles, widths = _pieces(points, sensor)
    bodies = _bodies(middles, widths)
    centres, radii, number = _measured(middles, widths, bodies)
    labels = np.where(pieces >= 0, number[bodies[pieces]] if len(bodies) else -1, -1)
    return ScanClusters(centres, radii, labels)


@compiled_for("(f8[:,::1], f8[::1])")
def _pieces(points: FloatArray, sensor: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the piece of each point (n,), -1 for lone ones, and middles (k, 2) and widths (k,) of pieces."""
    count = len(points)
    piece, pieces = np.empty(count, dtype=np.int64), 0
    for i in range(count):
        pieces += i > 0 and _apart(points, i, i - 1) > BREAK_M
        piece[i] = pieces
    if count > 2 and pieces > 0 and _apart(points, 0, count - 1) <= BREAK_M:
        for i in range(count - 1, -1, -1):  # the first and the last beam are neighbours
            if piece[i] != pieces:
                break
            piece[i] = 0
    low, high = np.full((pieces + 1, 2), np.inf), np.full((pieces + 1, 2), -np.inf)
    total, sizes = np.zeros((pieces + 1, 2)), np.zeros(pieces + 1)
    for i in range(count):
        own = piece[i]
        sizes[own] += 1.0
        for k in range(2):
            total[own, k] += points[i, k]
            low[own, k] = min(low[own, k], points[i, k])
            high[own, k] = max(high[own, k], points[i, k])
    number, found = np.full(pieces + 1, -1, dtype=np.int64), 0
    middles, widths = np.empty((pieces + 1, 2)), np.empty(pieces + 1)
    for own in range(pieces + 1):
        width = math.hypot(high[own, 0] - low[own, 0], high[own, 1] - low[own, 1])
        if sizes[own] < MIN_POINTS or width > MAX_EXTENT_M:
            continue
        x, y = total[own, 0] / sizes[own], total[own, 1] / sizes[own]
        away = max(math.hypot(x - sensor[0], y - sensor[1]), 1e-9)
        middles[found, 0] = x + DEPTH_SHARE * width * (x - sensor[0]) / away
        middles[found, 1] = y + DEPTH_SHARE * width * (y - sensor[1]) / away
        widths[found], number[own] = width, found
        found += 1
    for i in range(count):
        piece[i] = number[piece[i]]
    return piece, middles[:found], widths[:found]


@compiled
def _apart(points: FloatArray, i: int, j: int) -> float:
    return math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])


@compiled_for("(f8[:,::1], f8[::1])")
def _bodies(middles: FloatArray, widths: FloatArray) -> IntArray:
    """Return the body (k,) of each piece: small pieces near each other are one, large ones stay alone.

    The two nearest bodies are joined until no two are as near (complete linkage). A body's number is that of
    its first piece.
    """
    count = len(middles)
    bodies, apart = np.arange(count), np.full((count, count), np.inf)
    for i in range(count):
        for j in range(i):
            if max(widths[i], widths[j]) < 0.5 * PAIR_DISTANCE_M:
                apart[i, j] = apart[j, i] = _apart(middles, i, j)
    while True:
        nearest, one, other = np.inf, 0, 0
        for i in range(count):
            for j in range(i):
                if apart[i, j] < nearest:
                    nearest, one, other = apart[i, j], j, i
        if nearest > PAIR_DISTANCE_M:
            return bodies
        for i in range(count):
            if i != one:
                apart[one, i] = apart[i, one] = max(apart[one, i], apart[other, i])
            apart[other, i] = apart[i, other] = np.inf
            if bodies[i] == other:
                bodies[i] = one


@compiled_for("(f8[:,::1], f8[::1], i8[::1])")
def _measured(
    middles: FloatArray, widths: FloatArray, bodies: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return middles (b, 2) and radii (b,) of the bodies that are small enough, and the number (k,) among
    them of the body whose first piece each piece is; -1 if it is none's.
    """
    count, found = len(bodies), 0
    centres, radii, number = np.empty((count, 2)), np.empty(count), np.full(count, -1, dtype=np.int64)
    for body in range(count):
        x, y, parts, radius = 0.0, 0.0, 0, 0.0
        for i in range(body, count):
            if bodies[i] == body:
                x, y, parts = x + middles[i, 0], y + middles[i, 1], parts + 1
        if not parts:
            continue
        x, y = x / parts, y / parts
        for i in range(body, count):
            if bodies[i] == body:
                radius = max(radius, math.hypot(middles[i, 0] - x, middles[i, 1] - y) + 0.5 * widths[i])
        if 2.0 * radius <= MAX_EXTENT_M:
            centres[found, 0], centres[found, 1], radii[found], number[body] = x, y, radius, found
            found += 1
    return centres[:found], radii[:found], number
