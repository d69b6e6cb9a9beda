"""A Fail outdoors: how far the base came is measured, and held against what is needed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import Rig
from handcart.networks.task.preparing import prepare
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp
from handcart.primitives.restoring.car_shunting import CAR_ROOM, ROCK_POSITION_TOLERANCE_M
from handcart.primitives.restoring.snapshot import Snapshot, residuals, take_snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"


class ComesBack(ActionPrimitive):
    """Drives ahead for some seconds, then finds something wrong."""

    seconds: float
    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        end = robot.time + self.seconds
        while robot.time < end:
            robot.base.drive(0.4, 0.02)
            yield
        raise Discrepancy("it was for nothing")


class Needs(ComesBack):
    """The base must not be off by more than some metres."""

    room: float

    def base_room(self, robot: Robot, model: ModelView) -> float:
        return self.room


class Strays(ComesBack):
    """Comes back beside its start, as after gyros with an unknown bias led it."""

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from super().restore(robot, model, start, trace)
        end = robot.time + 6.0
        while robot.time < end:
            robot.base.drive(0.4, 0.15)
            yield


@pytest.fixture
def rig() -> Iterator[Rig]:
    """A robot whose gyros have learned their bias for ten seconds."""
    with prepare(TASK, None, {}, 3) as prepared:
        for _ in range(400):
            prepared.robot.step()
        yield Rig(prepared.robot, prepared.model, prepared.backend)


def base(rig: Rig) -> Pose2:
    truth = rig.backend.ground_truth()
    assert truth is not None
    return truth.base


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [14.0, 38.0])
def test_it_is_known_how_far_it_came_back(rig: Rig, seconds: float) -> None:
    """Within what is needed, after standing for a while if it came far; where on the Earth it is, isn't."""
    before = base(rig)
    outcome = rig.do(ComesBack(seconds=seconds))
    assert isinstance(outcome, Fail)
    tolerance = rig.robot.spec.tolerance
    assert outcome.residuals["base_unsure_mm"] < tolerance.base_mm
    off = 1e3 * base(rig).distance(before)
    assert abs(off - outcome.residuals["base_mm"]) < outcome.residuals["base_unsure_mm"] + 10.0
    assert off < tolerance.base_mm


@pytest.mark.slow
def test_what_a_primitive_needs_is_held_against_what_was_measured(rig: Rig) -> None:
    outcome = rig.do(Needs(seconds=20.0, room=0.01))
    assert isinstance(outcome, GiveUp)
    assert "(at most 10)" in outcome.reason
    assert isinstance(rig.do(Needs(seconds=1.0, room=9.0)), Fail)


def test_a_primitive_can_not_allow_itself_more_than_the_robot_s_file(rig: Rig) -> None:
    outcome = rig.do(Needs(seconds=1.0, room=9.0))
    assert isinstance(outcome, Fail)
    assert outcome.residuals.limits["base_mm"] == rig.robot.spec.tolerance.base_mm


@pytest.mark.slow
def test_fails_in_a_row_are_measured_from_where_the_first_began(rig: Rig) -> None:
    """The residuals of all of them add up, and are reported."""
    begun = base(rig)
    fails = []
    for _ in range(3):
        last = base(rig)
        fails.append(rig.do(ComesBack(seconds=6.0)))
    assert all(isinstance(fail, Fail) for fail in fails)
    by_this, in_all = (1e3 * base(rig).distance(before) for before in (last, begun))
    assert isinstance(fails[-1], Fail)
    measured = fails[-1].residuals["base_mm"]
    assert abs(measured - in_all) < abs(measured - by_this)


@pytest.mark.slow
def test_short_ways_that_are_not_driven_back_do_not_add_up(rig: Rig) -> None:
    begun = base(rig)
    for _ in range(8):
        assert isinstance(rig.do(ComesBack(seconds=0.2)), Fail)
    assert base(rig).distance(begun) < 0.15


@pytest.mark.parametrize(("jump", "off"), [(0.6, set()), (3.0, {"base_mm"})])
def test_a_pose_that_jumps_as_more_is_learned_is_no_motion(rig: Rig, jump: float, off: set[str]) -> None:
    """A jump within its uncertainty is allowed; a larger one means that the base was carried away."""
    stood = replace(take_snapshot(rig.robot, {}), pose_sigma=(0.4, 0.1))
    assert stood.odometry_pose is not None
    now = replace(stood, pose=Pose2(stood.pose.x + jump, *stood.pose[1:]))
    assert residuals(stood, now, rig.robot.spec).moved.keys() == off
    felt = Pose2(stood.odometry_pose.x + 0.6, *stood.odometry_pose[1:])
    assert residuals(stood, replace(now, odometry_pose=felt), rig.robot.spec).moved.keys() == {"base_mm"}


@pytest.mark.slow
def test_what_is_unsure_is_told_along_the_worst_direction(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """3 sigma of 0.2 m exceed the need, so the return is not confirmed."""
    unsure = Belief(np.zeros(3), np.diag([0.01, 0.2, 0.0]) ** 2)
    monkeypatch.setattr(type(rig.robot.localization), "displacement", property(lambda self: unsure))
    outcome = rig.do(ComesBack(seconds=1.0))
    assert isinstance(outcome, GiveUp)
    assert outcome.residuals["base_unsure_mm"] == pytest.approx(600.0)


@pytest.mark.parametrize("name", ["el_verde", "el_verde/rtk"])
def test_tolerance_is_the_clearance_of_a_planned_route(name: str) -> None:
    assert load_robot(name).tolerance.base_mm <= 1e3 * (ROCK_POSITION_TOLERANCE_M + CAR_ROOM)


@pytest.mark.slow
def test_a_car_beside_its_start_is_shunted_back_to_it(rig: Rig) -> None:
    """It cannot be moved sideways: a path forwards and backwards leads it to where the attempt began."""
    before = base(rig)
    outcome = rig.do(Strays(seconds=4.0))
    assert isinstance(outcome, Fail)
    tolerance = rig.robot.spec.tolerance
    assert 1e3 * base(rig).distance(before) < tolerance.base_mm
    assert np.degrees(base(rig).turn(before)) < tolerance.base_deg


@pytest.mark.slow
def test_a_car_is_not_shunted_onto_a_start_where_something_is(rig: Rig) -> None:
    before = base(rig)
    rig.model.obstacles = np.array([[rig.robot.pose.x - 1.0, rig.robot.pose.y]])
    outcome = rig.do(Strays(seconds=4.0))
    assert isinstance(outcome, GiveUp)
    assert base(rig).distance(before) > 1.5
