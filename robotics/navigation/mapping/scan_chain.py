"""Chain of keyframes: each matched with those shortly before it, from the odometry between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .line_matching import LineMatch, match_surfaces
from .pose_graph import Edge
from .scan_log import Keyframe
from .scan_surface import Surface, merge_surfaces
from .window_search import search_window

RECENT_KEYFRAMES = 10
"""Keyframes before the current one that it is matched with."""
MAX_EDGES, POINTS_PER_EDGE = 5, 60
"""Keyframes before one that share the information of its match: one for so many points, at most five.

Measured with 360 beams: the errors of neighbouring motions have a correlation of -0.5, and 100 keyframes
drift three times as far as one. With 120 beams the correlation is -0.3.
"""
MIN_INLIERS = 0.4
"""Share of points that must be explained; with fewer, only the odometry counts."""
GOOD_INLIERS = 0.7
"""Share of explained points from which no other motion is looked for."""
MIN_GAIN = 0.1
"""Share of points that another motion has to explain beyond that of the odometry."""
SEARCH_M, SEARCH_RAD = 0.6, 0.4
"""Distance and turn from the odometry at which other motions are looked for."""
ODOMETRY_SIGMAS = ((0.02, 0.1, 0.05), (0.01, 0.02, 0.1))
"""Standard deviation of position [m] and heading [rad]: at rest, per metre of travel, per radian of turn."""


def odometry_information(moved: Pose2) -> FloatArray:
    """Return the information matrix (3, 3) of a motion measured by uncalibrated wheels, in [1/m²] and
    [1/rad²].

    Rows are x, y and heading, in the base frame before the motion.

    Args:
        moved: pose of the base after the motion, in the base frame before the motion.
    """
    travel, turn = float(np.hypot(moved.x, moved.y)), abs(moved.theta)
    place, heading = (rest + metre * travel + radian * turn for rest, metre, radian in ODOMETRY_SIGMAS)
    return np.diag([place**-2, place**-2, heading**-2])


def chain(
    keyframes: Sequence[Keyframe], heard: Callable[[float], None] = lambda share: None
) -> tuple[list[Pose2], list[Edge], int]:
    """Match each keyframe with those before it.

    Args:
        keyframes: keyframes in order of time.
        heard: receives the finished share, 0 to 1.

    Returns:
        Poses of all keyframes in the base frame of the first one; edges between neighbours; number of motions
        that only odometry measured, because the scans did not fit.
    """
    poses, edges, blind = [Pose2(0.0, 0.0, 0.0)], list[Edge](), 0
    for number in range(1, len(keyframes)):
        frame, before = keyframes[number], keyframes[number - 1]
        moved = frame.odometry.relative_to(before.odometry)
        low = max(0, number - RECENT_KEYFRAMES)
        reference = submap(keyframes[low:number], poses[low:number], poses[number - 1])
        match = matched_motion(reference, frame.surface, moved)
        blind += match.inliers < MIN_INLIERS
        poses.append(poses[number - 1].compose(match.pose))
        edges += chain_edges(poses, match, len(frame.surface.points))
        heard(number / len(keyframes))
    return poses, edges, blind


def chain_edges(poses: Sequence[Pose2], match: LineMatch, points: int) -> list[Edge]:
    """Return the pose graph's edges (relative poses) of the last keyframe, which was matched with several
    earlier keyframes at once.

    Each edge leads to one of these keyframes; a scan with more points has more edges. The information of the
    match is divided among the edges. The error of the last pose is therefore that of a single match, and does
    not add to the errors of earlier matches. If only odometry measured the motion, there is a single edge, to
    the keyframe before.

    Args:
        poses: poses of the keyframes in order, in one frame; that of the last one as the match found it.
        match: match of the last keyframe; its pose is in the frame of the keyframe before.
        points: number of the keyframe's points on surfaces.
    """
    last = len(poses) - 1
    shared = max(1, min(MAX_EDGES, points // POINTS_PER_EDGE, last))
    count = shared if match.inliers >= MIN_INLIERS else 1
    edges = list[Edge]()
    for first in range(last - count, last):
        turn = poses[first].theta - poses[last - 1].theta
        cos, sin = np.cos(turn), np.sin(turn)
        rotation = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        information = rotation @ match.information @ rotation.T / count
        edges.append(Edge(first, last, poses[last].relative_to(poses[first]), information))
    return edges


def matched_motion(reference: Surface, surface: Surface, moved: Pose2) -> LineMatch:
    """Return the motion between two keyframes by scans and odometry; by odometry alone if the scans do not
    fit.

    Motions that differ from the odometry by up to `SEARCH_M` and `SEARCH_RAD` are searched.

    Args:
        reference: surfaces of earlier keyframes, in the base frame before the motion.
        surface: surface of the scan after the motion, in the base frame after it.
        moved: motion by odometry, base_T_base from before to after.
    """
    prior = odometry_information(moved)
    match = match_surfaces(reference, surface, moved, prior)
    if match.inliers < GOOD_INLIERS:
        found = search_window(reference.points, surface.points, moved, SEARCH_M, SEARCH_RAD)
        tried = [match_surfaces(reference, surface, hypothesis.pose, None) for hypothesis in found]
        best = max(tried, key=lambda line_match: line_match.inliers, default=match)
        if best.inliers > match.inliers + MIN_GAIN:
            match = match_surfaces(reference, surface, best.pose, 1e-2 * prior)
    if match.inliers < MIN_INLIERS:
        return LineMatch(moved, prior, match.inliers, match.sigma)
    return match


def submap(keyframes: Sequence[Keyframe], poses: Sequence[Pose2], frame: Pose2) -> Surface:
    """Return the surfaces that the scans of all given keyframes show, merged and converted to one frame.

    Args:
        keyframes: the keyframes.
        poses: pose of each keyframe, in any one frame.
        frame: pose of the returned surfaces' frame, in the same frame as `poses`.
    """
    return merge_surfaces(
        [
            keyframe.surface.moved(pose.relative_to(frame))
            for keyframe, pose in zip(keyframes, poses, strict=True)
        ]
    )
