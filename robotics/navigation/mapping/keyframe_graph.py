"""Graph of keyframes: motions between neighbours, and loop closures between places that are the same."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .line_matching import LineMatch
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
from .scan_chain import chain_edges
from .scan_log import Keyframe

Heard = Callable[[str, float], None]
"""Listener to progress, called with the present stage in words and its finished share, 0 to 1."""
MAX_ROUNDS = 6
"""Maximum number of searches for loops, each from better poses than the one before."""
REFINING_ROUNDS = 2
REFINING_VIEW_M = 2.0
SEARCH_STRIDE = 2
"""Step from one keyframe that is searched for loops to the next."""
CHI2_LIMIT = 3.0 * SCALING_CHI2
"""Squared error in sigmas from which a closure contradicts the others."""


def ignore_stage(words: str, share: float) -> None:
    """Ignore a report on the progress of map building, which names the stage and its finished share (0 to 1).

    This is the default for callers that want no reports.
    """


class KeyframeGraph:
    """Pose graph of a map, with keyframes, edges between neighbours, and loop closures found so far."""

    def __init__(self, frames: list[Keyframe], poses: list[Pose2], edges: list[Edge]) -> None:
        """Begin with one or more keyframes, their poses in the graph's frame, and edges of neighbours."""
        self.frames, self.poses, self._edges = frames, poses, edges
        self.accepted = list[Loop]()
        self._unsupported = list[Loop]()
        self._tried = dict[tuple[int, int], Pose2]()
        self._last_reason = dict[tuple[int, int], str]()
        places = np.array(poses)[:, :2]
        self._travel = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])

    @property
    def loop_edges(self) -> list[Edge]:
        """Accepted loop closures as edges of the graph, each the measured relative pose of two keyframes."""
        return [_edge(loop) for loop in self.accepted]

    @property
    def edges(self) -> list[Edge]:
        """All edges of the graph, from motions between neighbouring keyframes, measured poses, and loop
        closures.
        """
        return [*self._edges, *self.loop_edges]

    def append(self, frame: Keyframe, pose: Pose2, match: LineMatch) -> None:
        """Add a keyframe, and an edge by its match with the keyframes before it; the other poses stay
        unchanged.

        Args:
            frame: the keyframe.
            pose: pose of the keyframe in the graph's frame.
            match: pose of the keyframe in the frame of the keyframe before it, with the information matrix.
        """
        self._travel = np.append(self._travel, self._travel[-1] + pose.distance(self.poses[-1]))
        self.frames.append(frame)
        self.poses.append(pose)
        self._edges += chain_edges(self.poses, match, len(frame.surface.points))

    def measure(self, number: int, pose: Pose2, information: FloatArray) -> None:
        """Add the measured pose of a keyframe in the graph's frame; poses move only by `optimize`.

        The graph's frame is fixed by the first keyframe's pose, which never changes.

        Args:
            number: number of the keyframe.
            pose: measured pose of the base in the graph's frame.
            information: (3, 3) of x, y and heading along the axes of the graph's frame, in [1/m²] and
                [1/rad²].
        """
        cos, sin = math.cos(self.poses[0].theta), math.sin(self.poses[0].theta)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        self._edges.append(Edge(0, number, pose.relative_to(self.poses[0]), turn @ information @ turn.T))

    @property
    def rejected(self) -> Counter[str]:
        """Number of pairs of keyframes whose last candidate for a loop closure was rejected, by reason."""
        return Counter(reason for reason in self._last_reason.values() if reason)

    def search(self, heard: Heard = ignore_stage, since: int = 0) -> None:
        """Search for loop closures and optimize the poses, until no new closure is found.

        Args:
            heard: receives the progress.
            since: number of the first keyframe that is compared with earlier ones.
        """
        for number in range(MAX_ROUNDS):
            found = list(self._close(_stage(heard, f"closing loops, round {number + 1}"), since))
            self._note(found)
            again = {_pair_of(loop) for loop in found}
            waiting = (loop for loop in self._unsupported if _pair_of(loop) not in again)
            fitting = (loop for loop in found if not loop.reason and loop.match is not None)
            good = [*self.accepted, *waiting, *fitting]
            support = supported(good, self.poses)
            for loop, has_support in zip(good, support, strict=True):
                self._last_reason[_pair_of(loop)] = "" if has_support else "no other closure agrees"
            kept = [loop for loop, has_support in zip(good, support, strict=True) if has_support]
            self._unsupported = [loop for loop, there in zip(good, support, strict=True) if not there]
            if [_pair_of(loop) for loop in kept] == [_pair_of(loop) for loop in self.accepted]:
                break
            self.accepted = kept
            self.optimize()

    def refine(self, heard: Heard = ignore_stage) -> None:
        """Search again for loop closures between all keyframes that see the same place, and optimize the
        poses.

        The new loop closures replace the earlier ones. If there is none yet, nothing changes.
        """
        if not self.accepted:
            return
        for number in range(REFINING_ROUNDS):
            found = list(self._track(_stage(heard, f"refining, round {number + 1}")))
            good = [loop for loop in found if not loop.reason]
            if good:
                self.accepted = good
                self._note(found)
            self.optimize()

    def optimize(self) -> None:
        """Optimize the poses of the keyframes, without loop closures that contradict the other measurements
        by a squared error of more than `CHI2_LIMIT`.
        """
        while True:
            poses = optimize(np.array(self.poses), self.edges)
            errors = edge_errors(poses, self.loop_edges)
            contradicting = [loop for loop, e in zip(self.accepted, errors, strict=True) if e > CHI2_LIMIT]
            if not contradicting:
                break
            self._note(loop._replace(reason="contradicts the others") for loop in contradicting)
            self.accepted = [loop for loop, e in zip(self.accepted, errors, strict=True) if e <= CHI2_LIMIT]
        self.poses = [Pose2(*pose) for pose in poses.tolist()]

    def _note(self, loops: Iterable[Loop]) -> None:
        """Record the reasons of tested closures, each in place of an earlier one of its pair."""
        for loop in loops:
            self._last_reason[_pair_of(loop)] = loop.reason

    def _close(self, heard: Callable[[float], None], since: int) -> Iterable[Loop]:
        """Yield the result of each loop that is worth a try from the present poses."""
        poses, places = np.array(self.poses), dict[int, KeyframeView]()
        factor, diagonal = factorized(poses, self.edges), covariances(poses, self.edges)
        for second in range(since + since % SEARCH_STRIDE, len(poses), SEARCH_STRIDE):
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
        if any(_pair_of(loop) == pair for loop in self.accepted):
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
            places[number] = place_at(self.frames, self.poses, number)
        return places[number]


def _stage(heard: Heard, words: str) -> Callable[[float], None]:
    return lambda share: heard(words, share)


def _pair_of(loop: Loop) -> tuple[int, int]:
    return loop.first, loop.second


def _edge(loop: Loop) -> Edge:
    assert loop.match is not None
    return Edge(loop.first, loop.second, loop.match.pose, loop.match.information, is_loop=True)


def _in_frame_of(spread: FloatArray, second: FloatArray, first: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of first_T_second in the first frame, with a lower limit.

    Args:
        spread: (3, 3) covariance of the first pose relative to the second, along the axes of the graph's
            frame: x, y in [m] and heading in [rad].
        second: (3,) pose of the second keyframe in the graph's frame, in [m, m, rad].
        first: (3,) pose of the first keyframe in the graph's frame, in [m, m, rad].
    """
    turn = np.eye(3)  # seen from the first, a turn of it moves the second the other way
    turn[0, 2], turn[1, 2] = first[1] - second[1], second[0] - first[0]
    moved = turn @ spread @ turn.T
    cos, sin = np.cos(first[2]), np.sin(first[2])
    rotation = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    found: FloatArray = rotation @ moved @ rotation.T + np.diag([0.05, 0.05, 0.02]) ** 2
    return found
