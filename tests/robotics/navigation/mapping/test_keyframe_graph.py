"""Loop closures of a graph of keyframes: which are kept, and what the rejected ones leave behind."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping import keyframe_graph
from handcart.robotics.navigation.mapping.keyframe_graph import KeyframeGraph
from handcart.robotics.navigation.mapping.line_matching import LineMatch
from handcart.robotics.navigation.mapping.loop_closure import Loop
from handcart.robotics.navigation.mapping.pose_graph import Edge, optimize

SIDE = 4
"""Keyframes on each side of the square that is driven twice, 1 m apart."""
TRUE = [Pose2(0.0, 0.0, 0.0)]
for _number in range(1, 8 * SIDE):
    TRUE.append(TRUE[-1].compose(Pose2(1.0, 0.0, 0.0 if _number % SIDE else math.pi / 2)))
MOTION, CLOSURE = np.diag([400.0, 400.0, 1e4]), np.diag([900.0, 900.0, 1e4])
NOTHING = Pose2(0.0, 0.0, 0.0)


def graph() -> KeyframeGraph:
    chain = [Edge(n, n + 1, TRUE[n + 1].relative_to(TRUE[n]), MOTION) for n in range(len(TRUE) - 1)]
    return KeyframeGraph([], list(TRUE), chain)


def closure(first: int, second: int, off: Pose2 = NOTHING, reason: str = "") -> Loop:
    """A closure between two keyframes, `off` from the true relative pose."""
    pose = Pose2(*map(float, TRUE[second].relative_to(TRUE[first]).compose(off)))
    return Loop(first, second, LineMatch(pose, CLOSURE, 0.9, 0.01), 0.0, reason)


def pairs(loops: list[Loop]) -> list[tuple[int, int]]:
    return [(loop.first, loop.second) for loop in loops]


@pytest.fixture
def answer(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Lets tests of closures end as given by pair; all others fit nothing."""
    monkeypatch.setattr(keyframe_graph, "place_at", lambda frames, poses, number: None)

    def given(*loops: Loop) -> None:
        known = {(loop.first, loop.second): loop for loop in loops}

        def close(places: object, numbers: tuple[int, int], *args: object) -> Loop:
            return known.get(numbers, Loop(*numbers, None, 1.0, "nothing fits"))

        monkeypatch.setattr(keyframe_graph, "close_loop", close)
        monkeypatch.setattr(keyframe_graph, "track_loop", close)

    return given


def test_search_exchanges_closures_of_equal_number(answer: Callable[..., None]) -> None:
    made = graph()
    made.accepted = [closure(0, 16, Pose2(0.5, 0.0, 0.0)), closure(1, 17, Pose2(-0.5, 0.0, 0.0))]
    answer(closure(8, 24), closure(10, 26))
    made.search()
    assert pairs(made.accepted) == [(8, 24), (10, 26)]


def test_optimize_leaves_no_trace_of_dropped_closures() -> None:
    """Five of these ten contradict the others, one of them only when the other four are gone."""
    made, draws = graph(), np.random.default_rng(17)
    offs = [Pose2(*map(float, draws.normal(0.0, [0.2, 0.2, 0.05]))) for _ in range(10)]
    made.accepted = [closure(n, n + 16, off) for n, off in enumerate(offs)]
    made.optimize()
    assert len(made.accepted) == 5
    assert np.array(made.poses) == pytest.approx(optimize(np.array(TRUE), made.edges), abs=1e-4)
    assert made.rejected == {"contradicts the others": 5}


def test_refine_reports_the_closures_that_it_rejects(answer: Callable[..., None]) -> None:
    made = graph()
    answer(closure(8, 24), closure(10, 26), closure(12, 28, reason="ambiguous"))
    made.search()
    assert made.rejected["ambiguous"] == 1
    answer(closure(8, 24), closure(10, 26), closure(12, 28), closure(5, 21, Pose2(3.0, 0.0, 0.0)))
    made.refine()
    assert pairs(made.accepted) == [(8, 24), (10, 26), (12, 28)]
    assert made.rejected["ambiguous"] == 0
    assert made.rejected["contradicts the others"] == 1


def test_closure_tested_again_counts_once(answer: Callable[..., None]) -> None:
    """The first test had no support; after the poses moved, the pair is tested again."""
    made = graph()
    answer(closure(8, 24))
    made.search()
    assert not made.accepted
    made.poses = [pose if n < 20 else Pose2(pose.x + 0.35, pose.y, pose.theta) for n, pose in enumerate(TRUE)]
    answer(closure(8, 24), closure(10, 26))
    made.search()
    assert pairs(made.accepted) == [(8, 24), (10, 26)]
