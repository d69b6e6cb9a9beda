"""The robot above any backend: its time, exclusive motion, and estimates from its readings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.camera import AnyCamera, camera_of_kind
from handcart.backends.capabilities.missing_capability import MissingCapability
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.robot.robot import Robot
from handcart.backends.robot.robot_errors import StaleReading
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.numerics.arrays import ByteArray

SEAM = Path(__file__).parents[3] / "tasks" / "track_seam"
HALL = RigFiles(SEAM / "world.yaml", SEAM / "map.yaml", SEAM / "places.yaml", {})


@pytest.fixture
def make_stage() -> Iterator[Callable[..., Rig]]:
    made = []

    def one(robot: str, files: RigFiles = RigFiles()) -> Rig:
        made.append(build_rig(files, robot=robot))
        return made[-1]

    yield one
    for item in made:
        item.backend.close()


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
    """S2: a robot with wheel odometry alone, whose encoders are frozen, reports that it is lost."""
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
    """N12: in either order of their commands."""
    one, other = object(), object()
    seen = []
    for movers in ((one,), (one,), (one, other), (one,), (one,)):
        seen.append([robot.moved_by(mover) for mover in movers])
        robot.step()
    assert seen == [[True], [True], [True, False], [False], [True]]


def test_lowered_hand_is_masked_in_the_scan_and_a_raised_one_not(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.array([[0.6, 0.0], [0.6, 0.1], [0.6, 0.4], [2.0, 0.0]])
    for height, left in ((0.3, points[2:]), (0.9, points)):
        monkeypatch.setattr(robot, "base_T", lambda _, z=height: transform((0.6, 0.0, z)))
        assert robot.without_hand(points).tolist() == left.tolist()


def test_base_shifted_while_driving_is_not_reported_as_pushed(
    make_stage: Callable[..., Rig],
) -> None:
    """With indoor positioning, which takes over the new pose in either case."""
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


def test_base_at_rest_that_deflects_stands_but_creeping_does_not(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Encoders of 65,536 counts resolve a hundredth of a millimetre; no scan does."""
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


def test_a_new_robot_has_done_and_seen_nothing(robot: Robot) -> None:
    assert (robot.time, robot.driven) == (0.0, (0.0, 0.0))
    assert (robot.held, robot.progress.blocked, robot.seen, robot.failed_from) == (None, None, None, None)


def test_limits_are_those_of_its_files(robot: Robot) -> None:
    limits = robot.drive_limits
    assert tuple(limits) == pytest.approx((0.6, math.radians(90.0), 0.5, math.radians(120.0), 1.0, 0.0))
    assert robot.stopping_distance == pytest.approx(0.6 * 3 * 0.05 + 0.6**2 / (2 * 0.5))
    assert robot.joint_speeds == pytest.approx(np.full(6, math.radians(85.0)))
    assert 0.05 < robot.range_sensor_height < 0.6


def test_what_it_cannot_do_is_said_with_what_it_can(make_stage: Callable[..., Rig]) -> None:
    cart = make_stage("cart", HALL).robot
    with pytest.raises(
        MissingCapability, match="the robot has no Gripper; it has: Base, RangeSensor"
    ) as found:
        _ = cart.gripper
    assert found.value.exit_status == 2
    with pytest.raises(MissingCapability, match="no Arm"):
        _ = cart.arm_model
    assert camera_of_kind(cart.backend.capabilities(), AnyCamera) is None
    with pytest.raises(MissingCapability, match="no AnyCamera"):
        _ = cart.view_camera


def test_inertial_sensors_tell_how_it_turned(make_stage: Callable[..., Rig]) -> None:
    robot = make_stage("toyama", HALL).robot
    scene = simulated_world(robot.backend)
    assert scene is not None
    for _ in range(20):
        robot.step()
    rested, before = robot.attitude.moved, scene.base.theta
    assert rested <= robot.period  # in the first one it does not know whether the arm moves
    assert abs(robot.attitude.yaw) < 1e-4
    for _ in range(20):
        robot.base.drive(0.0, 0.4)
        robot.step()
    assert robot.attitude.moved - rested == pytest.approx(20 * robot.period, abs=2 * robot.period)
    assert robot.attitude.yaw == pytest.approx(scene.base.theta - before, abs=0.01)


@pytest.mark.parametrize(("localizer", "left"), [("scan", 4), ("gyro", 2)])
def test_a_lowered_hand_is_left_out_of_scans_outdoors_alone(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, localizer: str, left: int
) -> None:
    points = np.array([[0.6, 0.0], [0.6, 0.1], [0.6, 0.4], [2.0, 0.0]])
    monkeypatch.setattr("handcart.backends.robot.robot.steady_points", lambda _: points)
    monkeypatch.setattr(robot, "base_T", lambda _: transform((0.6, 0.0, 0.3)))
    robot.spec = robot.spec.model_copy(update={"localizer": localizer})
    assert robot.surroundings().tolist() == points[4 - left :].tolist()


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_a_picture_that_stays_the_same_as_it_moves_is_stale(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, noise: float
) -> None:
    errors = robot.spec.errors.model_copy(update={"image_noise_grey": noise})
    robot.spec = robot.spec.model_copy(update={"errors": errors})
    grey: ByteArray = np.full((4, 4), 7, np.uint8)
    travel = robot.base.wheel_travel()
    wheels = robot.backend.get(Base)  # type: ignore[type-abstract]
    monkeypatch.setattr(robot.camera, "image", lambda: grey)

    def rolled(way: float) -> None:
        monkeypatch.setattr(wheels, "wheel_travel", lambda: travel._replace(left=travel.left + way))
        robot.step()

    assert robot.picture() is grey
    assert robot.seen is grey
    rolled(0.0)
    robot.picture()
    rolled(0.9e-3)
    robot.picture()
    rolled(2.1e-3)
    with pytest.raises(StaleReading):
        robot.picture()
    rolled(0.9e-3)  # back: without noise it may look the same again
    if noise:
        with pytest.raises(StaleReading):
            robot.picture()
    else:
        robot.picture()
    grey = np.full((4, 4), 8, np.uint8)
    rolled(5e-3)
    assert robot.picture() is grey


def test_a_photo_has_the_cameras_pose_at_its_own_instant(robot: Robot) -> None:
    first, start = robot.photo(), robot.arm.joints()
    for share in np.linspace(0.05, 1.0, 20):
        robot.arm.move(start + 0.1 * share * np.eye(len(start))[0])
        robot.step()
    photo = robot.photo()
    assert photo.pixels is robot.seen
    assert photo.time == robot.time > first.time
    hand = robot.arm_model.forward(robot.arm.joints())
    assert np.array_equal(photo.base_T_camera, hand @ robot.camera.hand_T_camera)
    assert not np.allclose(photo.base_T_camera, first.base_T_camera, atol=1e-3)


def test_a_checkpoint_keeps_the_ground_that_was_driven(make_stage: Callable[..., Rig]) -> None:
    half = RangeSpec(beams=360, reach_m=12.0, sigma_mm=10.0, masked_deg=((100.0, 260.0),))
    robots = [make_stage("cart", HALL).robot for _ in range(2)]
    for item in robots:
        assert "driven" not in item.state()
        assert item.lidar is not None
        item.lidar.spec = half
    for _ in range(10):
        robots[0].base.drive(0.2, 0.0)
        robots[0].step()
    kept = robots[0].state()
    assert len(kept["driven"]["_driven"]) > 2
    robots[1].set_state(kept)
    assert robots[1].state()["driven"] == kept["driven"]


def test_waiting_lasts_as_long_as_it_says(robot: Robot) -> None:
    for seconds, periods in ((0.2, 4), (0.21, 5), (0.0, 0)):
        count = 0
        for _ in robot.wait(seconds):
            robot.step()
            count += 1
        assert count == periods


def test_a_stop_takes_back_what_was_commanded(robot: Robot) -> None:
    robot.base.drive(0.2, 0.1)
    robot.stop()
    robot.step()
    assert robot.driven == (0.0, 0.0)


def test_driven_base_is_blocked_by_how_far_wheels_and_pose_came(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The distance of a period is the mean of both wheels, not their sum or more."""
    taken: list[tuple[float, float]] = []
    monkeypatch.setattr(
        robot.progress._motion, "update", lambda speed, rolled, *poses: taken.append((speed, rolled))
    )
    for _ in range(12):
        robot.base.drive(0.2, 0.0)
        robot.step()
    speed, rolled = taken[-1]
    assert speed == pytest.approx(0.2)
    assert rolled == pytest.approx(0.2 * robot.period, rel=0.1)
    assert robot.progress.blocked is None
