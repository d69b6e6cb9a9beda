"""Closing of one loop: two places are matched, and tested against what each sees free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

from .line_matching import LineMatch, match_surfaces
from .ray_counts import RayCounts, count_rays
from .scan_chain import submap
from .scan_log import Keyframe
from .scan_surface import Surface
from .window_search import search_window

PLACE_KEYFRAMES = 6
"""Number of keyframes before and after a keyframe that belong to its place."""
CELL_M = 0.1
MIN_INLIERS = 0.5
MAX_CONTRADICTIONS = 0.1
"""Share of points that may lie where the other place saw free space."""
MIN_PASSES = 2
"""Minimum number of beams through a cell that show that it is free."""
SAMPLE_POINTS = 400
MAX_CHI2 = 16.3
"""Squared distance in sigmas from the predicted pose: 99.9 % of right ones are nearer."""
AMBIGUITY_RATIO = 0.9
"""Score of the second best hypothesis, relative to the best, from which the loop is ambiguous."""
APART_M, APART_RAD = 0.4, math.radians(6.0)
"""Distance and turn from which on two refined poses count as two hypotheses."""
MAX_REACH_M, MAX_REACH_RAD = 8.0, 0.7
MIN_REACH_M, MIN_REACH_RAD = 0.3, 0.1
REFINING_GATES_M = (0.6, 0.4, 0.2, 0.1)
TRACKING_GATES_M = (0.3, 0.15, 0.1)


class KeyframeView(NamedTuple):
    """Points sensed at a keyframe and its neighbours, and a map of the free space, in the keyframe's
    frame.
    """

    surface: Surface
    sample: Surface
    """Some points of the surface."""
    hits: FloatArray
    """(n, 2) where some of the beams ended, in [m]."""
    grid: GridMap
    """Occupied where beams ended, and next to it; free where `MIN_PASSES` beams passed."""

    def contradictions(self, hits: FloatArray) -> float:
        """Return the share, 0 to 1, of surface points that lie in space which this view has seen as free.

        Only points in known cells count; the result is 1 if there is no such point.

        Args:
            hits: (n, 2) points in the keyframe's frame, in [m].
        """
        cells = self.grid.to_cell(hits[self.grid.inside(hits)])
        rows, columns = cells[:, 0], cells[:, 1]
        known = np.count_nonzero(~self.grid.unknown[rows, columns])
        return 1.0 - np.count_nonzero(self.grid.occupied[rows, columns]) / known if known else 1.0


class Loop(NamedTuple):
    """Candidate of a loop closure between two keyframes, with the match of their scans and the reason if it
    is rejected.
    """

    first: int
    """Number of the earlier keyframe."""
    second: int
    """Number of the later keyframe."""
    match: LineMatch | None
    """Its `pose` is first_T_second; None if nothing fits."""
    contradictions: float
    """Share of points, 0 to 1, of one place that lie in the other's free space, the larger of both."""
    reason: str
    """Why it is rejected; empty if it may be right."""


def place_at(keyframes: Sequence[Keyframe], poses: Sequence[Pose2], number: int) -> KeyframeView:
    """Return the points seen from a keyframe and from its neighbours in time, in the keyframe's frame.

    Args:
        keyframes: all keyframes, in order of time.
        poses: pose of each keyframe, in any one frame.
        number: number of the keyframe.
    """
    low, high = max(0, number - PLACE_KEYFRAMES), number + PLACE_KEYFRAMES + 1
    frames, near = keyframes[low:high], [pose.relative_to(poses[number]) for pose in poses[low:high]]
    surface = submap(keyframes[low:high], poses[low:high], poses[number])
    hits = np.concatenate([pose.apply(frame.hits) for frame, pose in zip(frames, near, strict=True)])
    hits = hits[:: max(1, math.ceil(len(hits) / SAMPLE_POINTS))]
    return KeyframeView(
        surface, surface.thinned(SAMPLE_POINTS), hits, _thick(count_rays(frames, near, CELL_M))
    )


def _thick(counts: RayCounts) -> GridMap:
    near = cv2.dilate((counts.hits > 0).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    unknown = ~near & (counts.passes < MIN_PASSES)
    return GridMap(near, unknown, counts.resolution, *counts.origin)


def close_loop(
    places: tuple[KeyframeView, KeyframeView],
    numbers: tuple[int, int],
    predicted: Pose2,
    covariance: FloatArray,
) -> Loop:
    """Match the views of two keyframes, as a loop closure, within three sigmas of their predicted relative
    pose.

    The search covers at least 0.3 m and at most 8 m, and at least 0.1 rad and at most 0.7 rad, to either
    side.

    Args:
        places: views of the earlier and the later keyframe.
        numbers: numbers of the two keyframes.
        predicted: predicted first_T_second.
        covariance: (3, 3) of the prediction, x, y in [m] and heading in [rad], in the frame of the first
            keyframe.
    """
    sigma = 3.0 * math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1]))
    sigma_turn = 3.0 * math.sqrt(float(covariance[2, 2]))
    one, other = places
    seen = other.sample
    window = (
        min(max(sigma, MIN_REACH_M), MAX_REACH_M),
        min(max(sigma_turn, MIN_REACH_RAD), MAX_REACH_RAD),
    )
    starts = [
        hypothesis.pose for hypothesis in search_window(one.surface.points, seen.points, predicted, *window)
    ]
    tried = list[tuple[float, LineMatch, float]]()
    for start in [predicted, *starts]:
        match = match_surfaces(one.surface, seen, start, None, REFINING_GATES_M)
        away = _offset(match.pose, predicted)
        if float(away @ np.linalg.solve(covariance, away)) > MAX_CHI2:
            continue
        against = contradictions(places, match.pose)
        tried.append((match.inliers - against, match, against))
    if not tried:
        return Loop(*numbers, None, 1.0, "nothing fits")
    score, best, against = max(tried, key=lambda entry: entry[0])
    loop = Loop(*numbers, best, against, "")
    if best.inliers < MIN_INLIERS:
        return loop._replace(reason="little in common")
    if against > MAX_CONTRADICTIONS:
        return loop._replace(reason="one sees walls where the other saw free space")
    rivals = [entry for entry in tried if _is_apart(entry[1].pose, best.pose)]
    if any(rival[0] > AMBIGUITY_RATIO * score for rival in rivals):
        return loop._replace(reason="ambiguous")
    return loop


def contradictions(places: tuple[KeyframeView, KeyframeView], pose: Pose2) -> float:
    """Return the larger share, 0 to 1, of the scan points of one keyframe that lie in the free space seen
    from the other one.

    Args:
        places: views of the first and the second keyframe.
        pose: first_T_second.
    """
    one, other = places
    there = one.contradictions(pose.apply(other.hits))
    return max(there, other.contradictions(pose.inverse().apply(one.hits)))


def track_loop(places: tuple[KeyframeView, KeyframeView], numbers: tuple[int, int], predicted: Pose2) -> Loop:
    """Match the views of two keyframes whose relative pose is known approximately, as a loop closure.

    A match that differs from the prediction by more than `APART_M` or `APART_RAD` is rejected.

    Args:
        places: views of the earlier and the later keyframe.
        numbers: numbers of the two keyframes.
        predicted: predicted first_T_second.
    """
    match = match_surfaces(places[0].surface, places[1].sample, predicted, None, TRACKING_GATES_M)
    against = contradictions(places, match.pose)
    loop = Loop(*numbers, match, against, "")
    if match.inliers < MIN_INLIERS:
        return loop._replace(reason="little in common")
    if against > MAX_CONTRADICTIONS:
        return loop._replace(reason="one sees walls where the other saw free space")
    if _is_apart(match.pose, predicted):
        return loop._replace(reason="nothing fits")
    return loop


def _offset(pose: Pose2, other: Pose2) -> FloatArray:
    return np.array([pose.x - other.x, pose.y - other.y, wrap(pose.theta - other.theta)])


def _is_apart(pose: Pose2, other: Pose2) -> bool:
    return pose.distance(other) > APART_M or pose.turn(other) > APART_RAD
