"""The robot above any backend: its time, who moves it, what it makes of its readings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.evaluation.truth.survey import simulated_world
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform

SEAM = Path(__file__).parents[3] / "tasks" / "track_seam"
HALL = RigFiles(SEAM / "world.yaml", SEAM / "map.yaml", SEAM / "places.yaml", {})


@pytest.fixture
def make_stage() -> Iterator[Callable[..., Rig]]:
    made = []

    def one(robot: str, files: RigFiles = RigFiles()) -> Rig:
        made.append(build_rig(files, robot=robot))
        return made[-1]

    yield one
    for each in made:
        each.backend.close()


@pytest.fixture
def robot(make_stage: Callable[..., Rig]) -> Robot:
    return make_stage("librarian").robot


def test_in_a_pause_its_time_stands_still_and_its_readings_go_on(robot: Robot) -> None:
    backend, before = simulated_world(robot.backend), robot.time
    assert backend is not None
    for _ in range(5):
        robot.step(paused=True)
    assert robot.time == before
    assert backend.time == pytest.approx(5 * robot.period)
    robot.step()
    assert robot.time == pytest.approx(before + robot.period)


def test_computing_takes_its_time_and_the_robot_holds(robot: Robot) -> None:
    periods, work = 0, robot.compute(lambda a, b: a + b, 2, 3, takes=0.5)
    while True:
        try:
            next(work)
        except StopIteration as end:
            assert end.value == 5
            break
        periods += 1
        robot.step()
        assert robot.driven == (0.0, 0.0)
    assert periods == 10


def test_s2_driven_wheels_that_read_the_same_tell_nothing(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """S2: a robot that reckons by its wheels alone, whose encoders stand still, says that it is lost."""
    robot = make_stage("toyama").robot
    wheels = robot.get(Base)  # type: ignore[type-abstract]
    stood = wheels.wheel_travel()
    with monkeypatch.context() as broken:
        broken.setattr(wheels, "wheel_travel", lambda: stood)
        way = 0.0
        while robot.localization.lost is None:
            robot.base.drive(0.1, 0.0)
            robot.step()
            way += 0.1 * robot.period
            assert way < 0.05
        assert way > 0.025
        assert robot.localization.sigma == (math.inf, math.inf)
        robot.step()  # at rest it is lost as before
        assert robot.localization.lost is not None
    robot.step()
    assert robot.localization.lost is None


def test_two_that_move_it_are_noticed_in_the_next_period_too(robot: Robot) -> None:
    """N12: whoever of them is asked first."""
    one, other = object(), object()
    seen = []
    for movers in ((one,), (one,), (one, other), (one,), (one,)):
        seen.append([robot.moved_by(each) for each in movers])
        robot.step()
    assert seen == [[True], [True], [True, False], [False], [True]]


def test_a_lowered_hand_hides_itself_from_the_scan_and_a_raised_one_nothing(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.array([[0.6, 0.0], [0.6, 0.1], [0.6, 0.4], [2.0, 0.0]])
    for height, left in ((0.3, points[2:]), (0.9, points)):
        monkeypatch.setattr(robot, "base_T", lambda _, z=height: transform((0.6, 0.0, z)))
        assert robot.without_hand(points).tolist() == left.tolist()


def test_a_base_that_was_shifted_while_it_drove_was_not_pushed_while_it_stood(
    make_stage: Callable[..., Rig],
) -> None:
    """By an indoor positioning; it takes the place over in either case."""
    robot = make_stage("atrv", HALL).robot
    scene = simulated_world(robot.backend)
    assert scene is not None

    def shifted(speed: float) -> int:
        for period in range(50):
            if period == 25:
                scene.base = scene.base.compose(Pose2(0.0, 0.2, 0.0))
            robot.base.drive(speed, 0.0)
            robot.step()
        assert robot.pose.distance(scene.base) < 0.01
        return robot.localization.displacements

    assert [shifted(0.1), shifted(0.0)] == [0, 1]


def test_a_base_that_gives_way_under_its_arm_stands_and_one_that_creeps_does_not(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Encoders of 65,536 counts tell a hundredth of a millimetre; no scan tells that."""
    robot = make_stage("librarian", HALL).robot
    base: Base | None = robot.backend.get(Base)  # type: ignore[type-abstract]
    travel = robot.base.wheel_travel()

    def places(a_period: float) -> int:
        seen = set()
        for period in range(60):
            read = WheelTravel(travel.left + a_period * period, travel.right + 2e-5 * (period % 3))
            monkeypatch.setattr(base, "wheel_travel", lambda read=read: read)
            robot.step()
            seen.add(tuple(np.round(robot.pose, 4).tolist()))
        return len(seen)

    places(0.0)
    assert places(0.0) <= 6
    monkeypatch.setattr(base, "wheel_travel", lambda: WheelTravel(travel.left + 1e-3, travel.right))
    robot.step()
    travel = WheelTravel(travel.left + 1.19e-3, travel.right)  # the last of its roll
    places(0.0)
    travel = WheelTravel(travel.left + 2e-5, travel.right)
    assert places(0.0) <= 6
    assert robot.localization.still > 100
    assert places(3e-5) > 20
    assert robot.localization.still < 20


def test_an_old_scan_holds_no_base_back_that_drives(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """S1: it fits the map very well, where the base no longer is."""
    robot.step()
    scene, old = simulated_world(robot.backend), robot.range_sensor.scan()
    assert scene is not None
    monkeypatch.setattr(robot.range_sensor, "scan", lambda: old)
    for _ in range(60):
        robot.base.drive(0.15, 0.0)
        robot.step()
    for _ in range(10):
        robot.step()
    assert robot.pose.distance(scene.base) < 0.03
