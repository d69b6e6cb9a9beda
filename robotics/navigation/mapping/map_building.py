"""Construction of a map from a log: chain of keyframes, loop closures, pose graph, cells."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .loop_closure import KeyframeView, Loop, close_loop, place_at, track_loop
from .loop_search import Candidate, candidates, supported
from .pose_graph import (
    SCALING_CHI2,
    Edge,
    covariances,
    edge_errors,
    factorized,
    optimize,
    relative_covariances,
)
from .ray_counts import RayCounts, count_rays
from .scan_chain import chain
from .scan_log import Keyframe, ScanLog, keyframe, keyframe_rows

Heard = Callable[[str, float], None]
"""Receives what is being done, and its finished share."""
MAX_ROUNDS = 6
"""Searches for loops, each from better poses than the one before."""
REFINING_ROUNDS = 2
REFINING_VIEW_M = 2.0
SEARCH_STRIDE = 2
"""Each second keyframe is searched for loops."""
CHI2_LIMIT = 3.0 * SCALING_CHI2
"""Squared error in sigmas from which a closure contradicts the others."""


class BuiltMap(NamedTuple):
    """A map, with the keyframes and loop closures from which it was built."""

    counts: RayCounts
    rows: list[int]
    """Rows of the log that are keyframes."""
    poses: FloatArray
    """(n, 3) map_T_base of each keyframe; the map's frame is that of the first odometry pose."""
    covariances: FloatArray
    """(n, 3, 3) of each pose relative to the first, in [m, m, rad]."""
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


def build_map(log: ScanLog, resolution: float, heard: Heard = lambda words, share: None) -> BuiltMap:
    """Build the map of a log.

    Args:
        log: scans and odometry.
        resolution: side of a cell, in [m].
        heard: receives what is being done, and its finished share, 0 to 1.

    Raises:
        TooLarge: the map would have too many cells.
    """
    rows = keyframe_rows(log)
    frames = [keyframe(log, row) for row in rows]
    start = frames[0].odometry
    poses, edges, blind = chain(frames, lambda share: heard("matching scans", share))
    graph = _Graph(frames, [start.compose(pose) for pose in poses], edges)
    graph.search(heard)
    graph.refine(heard)
    heard("drawing", 0.0)
    found = graph.poses
    return BuiltMap(
        count_rays(frames, found, resolution),
        rows,
        np.array(found),
        covariances(np.array(found), graph.edges),
        graph.accepted,
        graph.rejected,
        edge_errors(np.array(found), graph.loop_edges),
        blind,
        max(pose.distance(start.compose(before)) for pose, before in zip(found, poses, strict=True)),
    )


class _Graph:
    """Keyframes, the edges between neighbours and the loop closures found so far."""

    def __init__(self, frames: list[Keyframe], poses: list[Pose2], edges: list[Edge]) -> None:
        self._frames, self.poses, self._edges = frames, poses, edges
        self.accepted = list[Loop]()
        self.rejected = Counter[str]()
        self._tried = dict[tuple[int, int], Pose2]()
        self._last_reason = dict[tuple[int, int], str]()
        places = np.array(poses)[:, :2]
        self._travel = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])

    @property
    def loop_edges(self) -> list[Edge]:
        """The accepted loop closures as edges."""
        return [_edge(loop) for loop in self.accepted]

    @property
    def edges(self) -> list[Edge]:
        """All edges."""
        return [*self._edges, *self.loop_edges]

    def search(self, heard: Heard) -> None:
        """Look for loops until no new one is found."""
        for number in range(MAX_ROUNDS):
            found = list(self._close(_stage(heard, f"closing loops, round {number + 1}")))
            for loop in found:
                self._last_reason[loop.first, loop.second] = loop.reason
            good = [*self.accepted, *(loop for loop in found if not loop.reason and loop.match is not None)]
            support = supported(good, self.poses)
            for loop, has_support in zip(good, support, strict=True):
                self._last_reason[loop.first, loop.second] = "" if has_support else "no other closure agrees"
            kept = [loop for loop, has_support in zip(good, support, strict=True) if has_support]
            if len(kept) == len(self.accepted):
                break
            self.accepted = kept
            self._optimize()
        self.rejected = Counter(reason for reason in self._last_reason.values() if reason)

    def refine(self, heard: Heard) -> None:
        """Replace the closures by ones between all keyframes that see the same place."""
        if not self.accepted:
            return
        for number in range(REFINING_ROUNDS):
            found = list(self._track(_stage(heard, f"refining, round {number + 1}")))
            good = [loop for loop in found if not loop.reason]
            self.accepted = good or self.accepted
            self._optimize()

    def _optimize(self) -> None:
        """Move the poses to the optimum, without the closures that contradict the others."""
        for _ in range(2):
            poses = optimize(np.array(self.poses), self.edges)
            errors = edge_errors(poses, self.loop_edges)
            for loop, error in zip(self.accepted, errors, strict=True):
                if error > CHI2_LIMIT:
                    self._last_reason[loop.first, loop.second] = "contradicts the others"
            self.accepted = [loop for loop, e in zip(self.accepted, errors, strict=True) if e <= CHI2_LIMIT]
        self.poses = [Pose2(*pose) for pose in poses.tolist()]

    def _close(self, heard: Callable[[float], None]) -> Iterable[Loop]:
        """Yield the result of each loop that is worth a try from the present poses."""
        poses, places = np.array(self.poses), dict[int, KeyframeView]()
        factor, diagonal = factorized(poses, self.edges), covariances(poses, self.edges)
        for second in range(0, len(poses), SEARCH_STRIDE):
            heard(second / len(poses))
            spreads = relative_covariances(factor, poses, second, diagonal)
            sigmas = np.sqrt(np.linalg.eigvalsh(spreads[:, :2, :2])[:, -1])
            for candidate in candidates(poses, self._travel, second, sigmas):
                predicted = self.poses[second].relative_to(self.poses[candidate.first])
                if not self._is_new(candidate, predicted):
                    continue
                both = self._place(places, candidate.first), self._place(places, second)
                spread = _in_frame_of(spreads[candidate.first], poses[second], poses[candidate.first])
                yield close_loop(both, (candidate.first, second), predicted, spread)

    def _is_new(self, candidate: Candidate, predicted: Pose2) -> bool:
        """Return whether a pair was not tried yet from about this prediction, and remember it."""
        pair = candidate.first, candidate.second
        if any((loop.first, loop.second) == pair for loop in self.accepted):
            return False
        last = self._tried.get(pair)
        if last is not None and last.distance(predicted) < 0.3 and last.turn(predicted) < 0.05:
            return False
        self._tried[pair] = predicted
        return True

    def _track(self, heard: Callable[[float], None]) -> Iterable[Loop]:
        poses, places = np.array(self.poses), dict[int, KeyframeView]()
        sigmas = np.zeros(len(poses))
        for second in range(len(poses)):
            heard(second / len(poses))
            for candidate in candidates(poses, self._travel, second, sigmas, REFINING_VIEW_M):
                predicted = self.poses[second].relative_to(self.poses[candidate.first])
                both = self._place(places, candidate.first), self._place(places, second)
                yield track_loop(both, (candidate.first, second), predicted)

    def _place(self, places: dict[int, KeyframeView], number: int) -> KeyframeView:
        if number not in places:
            places[number] = place_at(self._frames, self.poses, number)
        return places[number]


def _stage(heard: Heard, words: str) -> Callable[[float], None]:
    return lambda share: heard(words, share)


def _edge(loop: Loop) -> Edge:
    assert loop.match is not None
    return Edge(loop.first, loop.second, loop.match.pose, loop.match.information, is_loop=True)


def _in_frame_of(spread: FloatArray, second: FloatArray, first: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of first_T_second in the first frame, with a lower limit.

    Args:
        spread: (3, 3) of the first pose relative to the second, in the graph's frame.
        second: (3,) pose of the second keyframe.
        first: (3,) pose of the first keyframe.
    """
    turn = np.eye(3)  # seen from the first, a turn of it moves the second the other way
    turn[0, 2], turn[1, 2] = first[1] - second[1], second[0] - first[0]
    moved = turn @ spread @ turn.T
    cos, sin = np.cos(first[2]), np.sin(first[2])
    rotation = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    found: FloatArray = rotation @ moved @ rotation.T + np.diag([0.05, 0.05, 0.02]) ** 2
    return found
