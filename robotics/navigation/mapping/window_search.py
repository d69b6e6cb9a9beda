"""Correlative scan matching (Olson, 2009): all poses of a window, scored on a blurred picture of surfaces."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled

CELL_M = 0.1
STRIDE_M = 0.2
"""Distance between the positions that are tried."""
BLUR_M = 0.15
"""Distance to a surface at which a point scores 0.6."""
MAX_POINTS = 120
MARGIN_M = 1.0
MAX_HYPOTHESES = 5
APART_M = 0.6
APART_RAD = math.radians(8.0)
"""Turn from which on two poses count as two hypotheses; `APART_M` is the distance."""


class Hypothesis(NamedTuple):
    """Candidate pose found by a search, with the score of how well scan points at this pose fit the mapped
    surfaces.
    """

    pose: Pose2
    score: float
    """Mean score of the points, 0 to 1."""


def search_window(
    surface_points: FloatArray, points: FloatArray, centre: Pose2, reach: float, reach_turn: float
) -> list[Hypothesis]:
    """Search for poses, near an expected pose, at which points fit a surface; return up to five of them.

    The best pose is the first. The poses differ from each other by more than `APART_M` or `APART_RAD`.

    Args:
        surface_points: (n, 2) points of the surface, in the reference frame, in [m].
        points: (m, 2) points to fit, in their own frame `moved`, in [m].
        centre: expected reference_T_moved, in the middle of the searched window; the window's sides are along
            the reference axes.
        reach: half side of the window, in [m].
        reach_turn: largest turn from `centre` to either side, in [rad].
    """
    if not len(surface_points) or not len(points):
        return []
    picture, low = _blurred(surface_points)
    points = np.ascontiguousarray(points[:: max(1, math.ceil(len(points) / MAX_POINTS))])
    far = max(1.0, float(np.quantile(np.hypot(points[:, 0], points[:, 1]), 0.9)))
    step = min(math.radians(4.0), STRIDE_M / far)
    turns = centre.theta + _steps(reach_turn, step)
    offsets = _steps(reach, STRIDE_M)
    scores = _scores(picture, points, turns, centre.x + offsets - low[0], centre.y + offsets - low[1], CELL_M)
    found = list[Hypothesis]()
    for index in np.argsort(scores, axis=None)[::-1][:2000]:
        turn, x, y = np.unravel_index(index, scores.shape)
        place = centre.x + float(offsets[x]), centre.y + float(offsets[y])
        pose = Pose2(*place, wrap(float(turns[turn])))
        if all(
            pose.distance(hypothesis.pose) > APART_M or pose.turn(hypothesis.pose) > APART_RAD
            for hypothesis in found
        ):
            found.append(Hypothesis(pose, float(scores[turn, x, y])))
            if len(found) == MAX_HYPOTHESES:
                break
    return found


def _steps(reach: float, step: float) -> FloatArray:
    """Return the multiples (n,) of a step from -reach to reach, at least."""
    count = math.ceil(reach / step)
    return step * np.arange(-count, count + 1, dtype=np.float64)


def _blurred(points: FloatArray) -> tuple[SingleArray, FloatArray]:
    """Return the score of each cell (h, w), row 0 at the lowest y, and the lower-left corner (2,) in [m]."""
    low = points.min(axis=0) - MARGIN_M
    cells = ((points - low) / CELL_M).astype(np.int64)
    width, height = ((points.max(axis=0) + MARGIN_M - low) / CELL_M).astype(np.int64) + 1
    away = np.ones((height, width), np.uint8)
    away[cells[:, 1], cells[:, 0]] = 0
    distance = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
    return np.exp(-0.5 * (distance / BLUR_M) ** 2).astype(np.float32), low


@compiled
def _scores(
    picture: SingleArray, points: FloatArray, turns: FloatArray, xs: FloatArray, ys: FloatArray, cell: float
) -> SingleArray:
    """Return the mean score (turns, xs, ys) of points (n, 2) at each pose."""
    height, width = picture.shape
    found = np.zeros((len(turns), len(xs), len(ys)), np.float32)
    for t in range(len(turns)):
        cos, sin = math.cos(turns[t]), math.sin(turns[t])
        for k in range(len(points)):
            px = cos * points[k, 0] - sin * points[k, 1]
            py = sin * points[k, 0] + cos * points[k, 1]
            for i in range(len(xs)):
                column = math.floor((px + xs[i]) / cell)
                if column < 0 or column >= width:
                    continue
                for j in range(len(ys)):
                    row = math.floor((py + ys[j]) / cell)
                    if 0 <= row < height:
                        found[t, i, j] += picture[row, column]
    return found / np.float32(len(points))
