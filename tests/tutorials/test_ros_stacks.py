"""Nav2 and MoveIt as primitives, against servers that succeed, fail, lie or fall silent."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig, build_rig
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome, Success
from handcart.robotics.geometry.pose2 import Pose2

pytestmark = pytest.mark.slow
PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "ros_stacks"


@pytest.fixture(autouse=True)
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Import the package without installing it."""
    monkeypatch.syspath_prepend(str(PACKAGE))
    yield
    for name in [module for module in sys.modules if module.partition(".")[0] == "ros_stacks"]:
        del sys.modules[name]


class FakeNav2:
    """Drives towards the goal, by the robot's own pose; `kind` says what goes wrong after a metre."""

    def __init__(self, rig: Rig, kind: str) -> None:
        stacks = import_module("ros_stacks.stacks")
        self._rig, self._kind = rig, kind
        self._states, self._speeds = stacks.GoalState, stacks.Speeds
        self._start, self._goal = rig.robot.pose, rig.robot.pose
        self.closed = False

    def go_to(self, x: float, y: float, heading: float) -> None:
        self._goal = Pose2(x, y, heading)

    @property
    def _is_far(self) -> bool:
        return self._rig.robot.pose.distance(self._start) > 0.5

    def state(self) -> Any:
        states = self._states
        if self._kind == "rejects":
            return states.REJECTED
        if self._is_far and self._kind in ("aborts", "lies"):
            return states.ABORTED if self._kind == "aborts" else states.SUCCEEDED
        there = self._rig.robot.pose.distance(self._goal) < 0.03
        return states.SUCCEEDED if there else states.RUNNING

    def speeds(self) -> Any:
        if self._is_far and self._kind == "falls silent":
            return None
        if self._is_far and self._kind == "sends NaN":
            return self._speeds(math.nan, 0.0)
        pose = self._rig.robot.pose
        bearing = math.atan2(self._goal.y - pose.y, self._goal.x - pose.x)
        turn = math.remainder(bearing - pose.theta, 2.0 * math.pi)
        left = pose.distance(self._goal)
        return self._speeds(99.0 if self._kind == "races" else min(0.4, left + 0.02), turn)

    def cancel(self) -> None: ...

    def close(self) -> None:
        self.closed = True


def navigated(kind: str) -> tuple[Outcome, Rig, float, FakeNav2]:
    """Return the outcome of NAVIGATE a metre ahead, the rig, how far off the start it is, and the server."""
    kind_of = import_module("ros_stacks.navigate").Navigate
    with build_rig(robot="cart", seed=1) as rig:
        start, fake = rig.robot.pose, FakeNav2(rig, kind)
        goal = start.compose(Pose2(1.0, 0.0, 0.0))
        rig.model.places = {
            **rig.model.places,
            "ahead": Place(x_m=goal.x, y_m=goal.y, heading_deg=math.degrees(goal.theta)),
        }
        kind_of.connect = staticmethod(lambda: fake)
        outcome = rig.do(kind_of(place="ahead"))
        return outcome, rig, rig.robot.pose.distance(start), fake


def test_nav2_arrives_and_the_pose_is_measured() -> None:
    outcome, _, driven, fake = navigated("arrives")
    assert isinstance(outcome, Success) and fake.closed
    assert driven == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("aborts", "Nav2: the goal is aborted"),
        ("rejects", "Nav2: the goal is rejected"),
        ("falls silent", "Nav2 is silent"),
        ("sends NaN", "Nav2 sends the speeds"),
        ("lies", "not observed|effect"),
    ],
)
def test_a_navigation_that_fails_is_driven_back(kind: str, words: str) -> None:
    outcome, _rig, off, fake = navigated(kind)
    assert isinstance(outcome, Fail), outcome
    assert re.search(words, outcome.reason), outcome.reason
    assert off < 0.02 and fake.closed


def test_speeds_of_nav2_are_kept_within_the_limits_of_the_base() -> None:
    outcome, _, _, _ = navigated("races")
    assert not isinstance(outcome, GiveUp), outcome


class FakeMoveIt:
    """Plans straight lines in joint space; `kind` says what is wrong with them."""

    def __init__(self, rig: Rig, kind: str) -> None:
        stacks = import_module("ros_stacks.stacks")
        self._rig, self._kind = rig, kind
        self._states, self._waypoints = stacks.GoalState, stacks.Waypoints

    def plan(self, group: str, names: Sequence[str], goal: Sequence[float]) -> None:
        self._names, self._goal = list(names), np.array(goal)

    def state(self) -> Any:
        return self._states.ABORTED if self._kind == "finds none" else self._states.SUCCEEDED

    def path(self) -> Any:
        start, goal = self._rig.robot.arm.command(), self._goal
        if self._kind == "begins elsewhere":
            start = start + 0.2
        if self._kind == "ends elsewhere":
            goal = goal + 0.2
        points = np.linspace(start, goal, 5)
        if self._kind == "has NaN":
            points[2, 0] = math.nan
        names = self._names
        if self._kind == "is for another arm":
            names = [f"left_{name}" for name in names]
        if self._kind == "is in another order":
            return self._waypoints(names[::-1], points[:, ::-1].tolist())
        return self._waypoints(names, points.tolist())

    def why(self) -> str:
        return "error code -2"

    def close(self) -> None: ...


def arm_moved(kind: str) -> tuple[Outcome, float]:
    """Return the outcome of MOVE_GROUP to the posture `carry`, and how far the joints are off the start."""
    kind_of = import_module("ros_stacks.move_group").MoveGroup
    with build_rig(robot="librarian", seed=1) as rig:
        fake, start = FakeMoveIt(rig, kind), rig.robot.arm.joints()
        kind_of.connect = staticmethod(lambda: fake)
        outcome = rig.do(kind_of(posture="carry"))
        return outcome, float(np.abs(rig.robot.arm.joints() - start).max())


@pytest.mark.parametrize("kind", ["plans", "is in another order"])
def test_moveit_plans_and_the_joints_are_measured(kind: str) -> None:
    outcome, moved = arm_moved(kind)
    assert isinstance(outcome, Success), outcome
    assert moved > 0.1


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("finds none", "MoveIt: aborted: error code -2"),
        ("begins elsewhere", "path begins 0.2"),
        ("ends elsewhere", "path ends 0.2"),
        ("has NaN", "finite points"),
        ("is for another arm", "path is for left_"),
    ],
)
def test_a_path_that_cannot_be_followed_moves_nothing(kind: str, words: str) -> None:
    outcome, moved = arm_moved(kind)
    assert isinstance(outcome, Fail), outcome
    assert words in outcome.reason and moved < 0.01


def test_a_stack_that_is_not_installed_is_a_fail_with_its_name() -> None:
    kind_of, stacks = import_module("ros_stacks.navigate").Navigate, import_module("ros_stacks.stacks")

    def missing() -> Any:
        raise stacks.NoStack("nav2_msgs is not installed")

    kind_of.connect = staticmethod(missing)
    with build_rig(robot="cart", seed=1) as rig:
        outcome = rig.do(kind_of(place="shelf_1"))
    assert isinstance(outcome, Fail) and outcome.permanent
    assert outcome.reason == "nav2_msgs is not installed"
