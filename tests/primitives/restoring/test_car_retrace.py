"""A car is brought back along its own track, its arm on the same time line."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.arm_command import (
    GRIP_PAUSE,
    command_moment,
    hold_measured,
    moves_fingers,
    rejoin,
)
from handcart.primitives.restoring.car_retrace import MIN_STRETCH_M, car_retrace, check_stands
from handcart.primitives.restoring.trace import Moment
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief

from .rolling_car import PERIOD, Car, ramp


def test_a_way_ahead_is_driven_backwards_the_arm_with_it() -> None:
    car = Car()
    robot: Any = car
    start, trace = car.record(ramp(0.4, 60, 0.1))
    there = car.true
    assert there.x > 1.1
    periods = car.play(car_retrace(robot, start, trace))
    assert all(speed <= 0.0 for speed, _ in car.drives)
    assert car.true.distance(start.pose) < MIN_STRETCH_M
    assert car.true.turn(start.pose) < 0.05
    assert periods < 250
    assert car.joints.tolist() == [0.0, 0.0]
    first = [joints[0] for _, joints in car.arms]
    assert first == sorted(first, reverse=True)
    by_place = {round(moment.joints[0], 6): moment.pose.x for moment in trace.moments[1:]}
    late = [x - by_place[round(joints[0], 6)] for x, joints in car.arms if joints[0] > 0.005]
    assert max(map(abs, late)) < 0.12  # the arm is where it was when the base was there


def test_a_way_backwards_is_driven_ahead() -> None:
    car = Car()
    robot: Any = car
    start, trace = car.record(ramp(-0.3, 60))
    car.play(car_retrace(robot, start, trace))
    assert all(speed >= 0.0 for speed, _ in car.drives)
    assert car.true.distance(start.pose) < MIN_STRETCH_M


@pytest.mark.parametrize("rest", [0, 5])
def test_there_and_back_is_driven_in_two_stretches(rest: int) -> None:
    """The tracker starts again at a change of direction: both are driven, the last one first."""
    car = Car()
    robot: Any = car
    start, trace = car.record([*ramp(0.4, 50), *ramp(0.0, rest), *ramp(-0.4, 25, 0.2)])
    car.play(car_retrace(robot, start, trace))
    signs = [math.copysign(1.0, speed) for speed, _ in car.drives if speed]
    changes = sum(1 for a, b in pairwise(signs) if a != b)
    assert (signs[0], changes) == (1.0, 1)
    assert car.true.distance(start.pose) < MIN_STRETCH_M
    assert car.true.turn(start.pose) < 0.1


def test_a_standing_car_plays_its_arm_back_command_by_command() -> None:
    car = Car()
    robot: Any = car
    start, trace = car.record(ramp(0.0, 6))
    assert car.play(car_retrace(robot, start, trace)) == 5
    assert car.drives == []
    assert [joints[0] for _, joints in car.arms] == pytest.approx([0.04, 0.03, 0.02, 0.01, 0.0])


@pytest.mark.parametrize(("ahead_m", "sign"), [(0.6, -1.0), (-0.6, 1.0), (0.09, 0.0), (-0.09, 0.0)])
def test_what_short_ways_left_is_driven_straight_in_the_end(ahead_m: float, sign: float) -> None:
    """At 0.1 m/s; less than 0.1 m is not worth it."""
    car = Car()
    robot: Any = car
    start, trace = car.record([])
    car.true = Pose2(ahead_m, 0.0, 0.0)
    car.play(car_retrace(robot, start, trace))
    assert {speed for speed, _ in car.drives} == ({0.1 * sign} if sign else set())
    assert abs(car.true.x) == pytest.approx(0.0 if sign else abs(ahead_m), abs=0.006)


def test_how_far_it_came_goes_before_where_it_is_thought_to_be() -> None:
    """The displacement since the start is known, so the estimated pose is ignored."""
    car = Car()
    robot: Any = car
    start, trace = car.record([])
    car.displacement = Belief(np.array([0.4, 0.0, 0.0]), np.zeros((3, 3)))
    car.true = Pose2(-3.0, 0.0, 0.0)
    car.play(car_retrace(robot, start, trace))
    assert car.true.x == pytest.approx(-3.4, abs=0.006)


@pytest.mark.parametrize(
    ("off", "stands"),
    [
        ((0.099, 0.0, 0.0), True),
        ((0.0, 0.101, 0.0), False),
        ((0.0, 0.0, math.radians(4.9)), True),
        ((0.0, 0.0, math.radians(-5.1)), False),
    ],
)
def test_a_car_stands_where_its_file_allows_it_to(off: tuple[float, float, float], stands: bool) -> None:
    car = Car()
    robot: Any = car
    car.true = Pose2(*off)
    if stands:
        check_stands(robot, Pose2(0.0, 0.0, 0.0))
        return
    with pytest.raises(Discrepancy, match="the car doesn't reach its pose") as error:
        check_stands(robot, Pose2(0.0, 0.0, 0.0))
    assert error.value.measured == ("Base", "distance from its goal", math.hypot(*off[:2]), 0.1, "m")


def test_fingers_move_before_the_arm_and_get_their_time() -> None:
    car = Car()
    robot: Any = car
    moment = Moment(car.pose, np.array([0.2, 0.0]), 0.04)
    assert moves_fingers(robot, moment)
    periods = car.play(command_moment(robot, moment, periods=4))
    assert periods == round(GRIP_PAUSE / PERIOD) + 4
    assert car.grip == 0.04
    assert [joints[0] for _, joints in car.arms] == pytest.approx([0.05, 0.1, 0.15, 0.2])
    assert not moves_fingers(robot, moment)
    assert car.play(command_moment(robot, moment)) == 0  # it is there already
    assert not moves_fingers(robot, moment._replace(grip=0.04 + 5e-7))


@pytest.mark.parametrize("by", ["moment", "rejoin"])
def test_endless_joint_goes_back_the_short_way_round(by: str) -> None:
    """It was 6.2 rad further when the moment was recorded as 0 rad: a full turn is 0.08 rad away."""
    car, turn = Car(), 2.0 * math.pi
    robot: Any = car
    car.joints = np.array([6.2, 0.0])
    car.arm_model.nearest = lambda goal, start: goal + turn * np.round((start - goal) / turn)
    moment = Moment(car.pose, np.zeros(2), 0.0)
    car.play(command_moment(robot, moment, periods=4) if by == "moment" else rejoin(robot, moment))
    assert [joints[0] for _, joints in car.arms] == pytest.approx(np.linspace(6.2, turn, 5)[1:])


def test_arm_that_rejoins_a_moment_has_exactly_its_joints() -> None:
    """The last step is no sum, whose rounding would make it differ from what was commanded then."""
    car = Car()
    robot: Any = car
    car.joints = np.array([0.1, 0.7])
    goal = np.array([0.3, 0.1])
    assert np.any(car.joints + 1.0 * (goal - car.joints) != goal)
    assert car.play(rejoin(robot, Moment(car.pose, goal, 0.0))) == 12
    assert car.joints.tolist() == goal.tolist()
    assert car.play(rejoin(robot, Moment(car.pose, goal, 0.0))) == 0


def test_without_arm_and_fingers_a_moment_commands_nothing() -> None:
    car = Car(arm=False)
    robot: Any = car
    moment = Moment(car.pose, np.empty(0), 0.04)
    assert not moves_fingers(robot, moment)
    assert car.play(command_moment(robot, moment, 3)) == 0


@pytest.mark.parametrize(
    ("measured", "steps"),
    [
        ([0.05, 0.0], [0.0 + 0.025, 0.05]),  # 0.5 rad/s: 0.025 rad in a period
        ([0.025, 0.05], [0.025]),
        ([0.0, 0.0], [0.0]),
        ([1.2, 0.0], [0.025 * number for number in range(1, 41)]),  # beyond its limit: held at that
    ],
)
def test_an_arm_is_held_where_it_is_no_faster_than_its_joints(measured: Any, steps: list[float]) -> None:
    car = Car()
    robot: Any = car
    car.arm.joints = lambda: np.array(measured)
    assert car.play(hold_measured(robot)) == len(steps)
    assert [joints[0] for _, joints in car.arms] == pytest.approx(steps)
