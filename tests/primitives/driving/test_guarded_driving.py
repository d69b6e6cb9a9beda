"""No primitive's command brings the base into what map or scan shows, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.modify import Modify
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.primitives.restoring.retrace import reach_pose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import FloorBox
from tests.primitives.conftest import Rig

BOX = "surprises:\n  - {{name: box, x_m: {x}, y_m: {y}, size_m: [0.4, 0.4, {height}]{more}}}\n"


class DriveOn(ActionPrimitive):
    """Drives at full speed, whatever is there, and then fails."""

    turn_rate: float = 0.0

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(160):
            robot.base.drive(0.6, self.turn_rate)
            yield
        raise Discrepancy("that is all")


class ReachPose(ActionPrimitive):
    """Regulates to a pose near by."""

    x: float
    y: float

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from reach_pose(robot, Pose2(self.x, self.y, robot.pose.theta))


@pytest.mark.slow
@pytest.mark.parametrize("turn_rate", [0.0, 0.2, -0.35])
def test_full_speed_ahead_ends_before_a_wall_of_the_map(
    make_rig: Callable[..., Rig], turn_rate: float
) -> None:
    rig = make_rig()
    failed = rig.run(DriveOn(turn_rate=turn_rate))
    assert isinstance(failed, Fail)
    assert rig.scene.contacts == []
    assert math.dist(rig.scene.base[:2], (1.0, 1.0)) < 0.05  # it came back


def test_it_ends_before_a_box_that_the_scan_alone_shows(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX.format(x=1.0, y=2.6, height=0.6, more=""))
    assert isinstance(rig.run(DriveOn()), Fail)
    assert rig.scene.contacts == []


def test_it_ends_before_a_low_step_that_the_map_alone_shows(make_rig: Callable[..., Rig]) -> None:
    step = "  - {name: step, x_m: 1.0, y_m: 2.6, size_m: [0.8, 0.4, 0.08]}\n"
    rig = make_rig(furniture=step, walls=(FloorBox(1.0, 2.6, 0.0, 0.8, 0.4),))
    assert isinstance(rig.run(DriveOn()), Fail)
    assert rig.scene.contacts == []


@pytest.mark.slow
def test_restoring_waits_for_a_person_behind_the_base(
    make_rig: Callable[..., Rig],
) -> None:
    rig = make_rig(BOX.format(x=1.0, y=1.2, height=0.6, more=", appears_s: 7, leaves_s: 20"))
    assert isinstance(rig.run(DriveOn()), Fail)
    assert rig.scene.contacts == []
    assert rig.robot.time > 20.0


@pytest.mark.parametrize("off", [0.22, 0.25, 0.28, 0.30, 0.32, 0.335, 0.379])
def test_a_place_too_near_to_a_wall_is_refused_for_good(make_rig: Callable[..., Rig], off: float) -> None:
    rig = make_rig()
    places: Any = rig.model.places
    places["near"] = Place(x_m=5.0, y_m=0.06 + off, heading_deg=-90.0)
    for primitive in (MoveTo(place="near"), Modify(place="near")):
        failed = rig.run(primitive)
        assert isinstance(failed, Fail)
        assert failed.permanent
        words = "the base can't stand at near: something at (5.00, 0.06) m leaves "
        assert failed.reason == f"{words}{off:.3f} m to its middle, needed: 0.380 m"
    assert rig.robot.time < 2.0  # it never set out


@pytest.mark.slow
def test_a_place_as_near_as_can_be_is_reached_without_contact(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(seed=5)
    places: Any = rig.model.places
    places["near"] = Place(x_m=2.0, y_m=0.06 + 0.381, heading_deg=-90.0)
    assert isinstance(rig.run(MoveTo(place="near")), Success)
    assert rig.scene.contacts == []
    assert math.dist(rig.scene.base[:2], (2.0, 0.441)) < 0.04


@pytest.mark.slow
def test_a_pose_in_a_wall_is_told_to_be_held_by_the_map(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    failed = rig.run(ReachPose(x=1.0, y=0.3))
    assert isinstance(failed, Fail)
    assert "the base doesn't reach its pose: the map shows something at (1.0" in failed.reason
    assert rig.scene.contacts == []


@pytest.mark.slow
@pytest.mark.parametrize("start_y", [0.40, 0.43])
def test_a_start_too_near_to_a_wall_is_left_and_come_back_to(
    make_rig: Callable[..., Rig], start_y: float
) -> None:
    rig = make_rig(BOX.format(x=3.0, y=1.1, height=0.6, more=""), start_y=start_y)
    before = rig.scene.base
    failed = rig.run(MoveTo(place="shelf_1", wait_s=0.5, detour=False))
    assert isinstance(failed, Fail)
    assert rig.scene.base.distance(before) < 0.03
    assert rig.scene.contacts == []


@pytest.mark.slow
def test_unmapped_cupboard_at_a_wall_is_not_taken_for_the_wall(
    make_rig: Callable[..., Rig],
) -> None:
    """It is 8 cm deep: less than what a scan may be off the map by."""
    thin = "surprises:\n  - {name: cupboard, x_m: 5.0, y_m: 3.05, size_m: [0.8, 0.08, 1.0]}\n"
    wall = FloorBox(5.0, 3.14, 0.0, 5.9, 0.1)
    post = "  - {name: wall on the map, x_m: 5.0, y_m: 3.14, size_m: [5.9, 0.1, 1.0]}\n"
    rig = make_rig(thin, walls=(wall,), furniture=post)
    places: Any = rig.model.places
    places["beside"] = Place(x_m=5.0, y_m=3.08 - 0.39, heading_deg=0.0)
    failed = rig.run(MoveTo(place="beside", wait_s=1.0, detour=False))
    assert isinstance(failed, Fail)
    assert "the base doesn't get on to beside: the scan shows something at (" in failed.reason
    assert rig.scene.contacts == []
    assert len(rig.model.obstacles)


def test_waits_on_the_way_back_keep_the_limits_of_the_drive(
    make_rig: Callable[..., Rig],
) -> None:
    """A box is in the way for 4 s while the base drives back at full speed; nothing else slows the base."""
    rig = make_rig(BOX.format(x=1.0, y=1.3, height=0.6, more=", appears_s: 7.5, leaves_s: 12"))
    rig.model.places = {**rig.model.places, "ahead": Place(x_m=1.0, y_m=4.5, heading_deg=90.0)}
    move, step, rows = MoveTo(place="ahead", wait_s=9.0, detour=False), rig.robot.step, [(0.0, 0.0, 0.0)]

    def watched_step(paused: bool = False) -> None:
        step(paused)
        if move._restores:
            rows.append((rig.robot.time, rig.robot.command.along, rig.robot.command.turn_rate))

    rig.robot.step = watched_step  # type: ignore[method-assign]
    assert isinstance(rig.run(move, cancel=lambda: rig.robot.time > 6.5), Fail)
    speeds = [speed for time, speed, _ in rows if 10.0 < time < 12.0]
    assert min(speed for time, speed, _ in rows if 7.0 < time < 9.0) < -0.3
    assert speeds
    assert not any(speeds)
    limits, period = rig.robot.drive_limits, rig.robot.period
    for (_, speed, turn_rate), (_, faster, sharper) in pairwise(rows):
        assert abs(faster - speed) < limits.acceleration * period + 1e-6
        assert abs(sharper - turn_rate) < limits.turn_acceleration * period + 1e-6
