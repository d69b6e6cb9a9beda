"""Construction of a map from a log: chain of keyframes, loop closures, pose graph, cells."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .keyframe_graph import Heard, KeyframeGraph, ignore_stage
from .loop_closure import Loop
from .pose_graph import covariances, edge_errors
from .ray_counts import RayCounts, count_rays
from .scan_chain import chain
from .scan_log import ScanLog, keyframe, keyframe_rows


class BuiltMap(NamedTuple):
    """A map, with the keyframes and loop closures from which it was built."""

    counts: RayCounts
    rows: list[int]
    """Rows of the log that are keyframes."""
    poses: FloatArray
    """(n, 3) map_T_base of each keyframe; the map's frame is that of the first odometry pose."""
    covariances: FloatArray
    """(n, 3, 3) of each pose relative to the first, along the map's axes, in [m, m, rad]."""
    accepted: list[Loop]
    """Loop closures in the graph."""
    rejected: Counter[str]
    """Number of rejected loop closures by reason."""
    chi2: FloatArray
    """(m,) squared error in sigmas of each accepted closure."""
    blind: int
    """Number of motions that only the odometry measured."""
    shift: float
    """Largest distance in [m] by which the closures moved a pose."""


def build_map(log: ScanLog, resolution: float, heard: Heard = ignore_stage) -> BuiltMap:
    """Build a map from a log of scans and odometry.

    Args:
        log: scans and odometry.
        resolution: side of a cell, in [m].
        heard: receives the name of the present stage, and its finished share, 0 to 1.

    Raises:
        MapTooLarge: the map would have too many cells.
    """
    rows = keyframe_rows(log)
    frames = [keyframe(log, row) for row in rows]
    start = frames[0].odometry
    poses, edges, blind = chain(frames, lambda share: heard("matching scans", share))
    graph = KeyframeGraph(frames, [start.compose(pose) for pose in poses], edges)
    graph.search(heard)
    graph.refine(heard)
    heard("drawing", 0.0)
    return built_of(graph, rows, blind, [start.compose(pose) for pose in poses], resolution)


def built_of(
    graph: KeyframeGraph, rows: list[int], blind: int, before: list[Pose2], resolution: float
) -> BuiltMap:
    """Return the map drawn from the keyframes of a pose graph, with poses, covariances and loop closures.

    Args:
        graph: keyframes with their poses.
        rows: number of each keyframe's row in the log.
        blind: number of motions that only the odometry measured.
        before: map_T_base of each keyframe before the loop closures moved it.
        resolution: side of a cell, in [m].

    Raises:
        MapTooLarge: the map would have too many cells.
    """
    found = graph.poses
    return BuiltMap(
        count_rays(graph.frames, found, resolution),
        rows,
        np.array(found),
        covariances(np.array(found), graph.edges),
        graph.accepted,
        graph.rejected,
        edge_errors(np.array(found), graph.loop_edges),
        blind,
        max(pose.distance(first) for pose, first in zip(found, before, strict=True)),
    )
