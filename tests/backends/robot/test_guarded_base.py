"""Commands that the guarded wheels pass on."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base, DriveCommand, WheelTravel
from handcart.backends.capabilities.range_sensor import Scan
from handcart.backends.description.footprint_spec import FootprintSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.guarded_base import SIDE_MARGIN_M, GuardedBase, steady_points
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.bump_area import bump_fronts
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.tracking.moving_tracks import BodyTrack
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.numerics.arrays import FloatArray

NOTHING = np.empty((0, 2))
WALL_AT = 5.0


class Wheels(Base):
    """Wheels that note their commanded speed and turn rate, and do nothing by themselves."""

    def __init__(self) -> None:
        self.command = (0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        self.command = (speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        return WheelTravel(0.0, 0.0)


class Rolling:
    """A robot that moves exactly as its wheels are commanded, on a map with a wall from x = 5 m on."""

    def __init__(self, spec: RobotFile, x: float, scan: Callable[[Pose2], FloatArray]) -> None:
        solid = np.zeros((100, 60), dtype=np.bool_)
        solid[:, 50:] = True
        self.pose, self.wheels, self.period = Pose2(x, 5.0, 0.0), Wheels(), spec.period_s
        grid = GridMap(solid, np.zeros_like(solid), 0.1, 0.0, 0.0)
        self.base = GuardedBase(self.wheels, spec, grid, lambda: self.pose, lambda: scan(self.pose))

    def drive(self, speed: float, turn_rate: float = 0.0) -> tuple[float, float]:
        """A period; gives what was passed on."""
        self.base.drive(speed, turn_rate)
        forward, turn = self.wheels.command
        self.pose = self.pose.compose(Pose2(forward * self.period, 0.0, turn * self.period))
        return forward, turn


@pytest.fixture
def spec() -> RobotFile:
    return load_robot("librarian")


def test_it_is_never_faster_than_it_can_brake_from(spec: RobotFile) -> None:
    rolling, braking = Rolling(spec, 3.0, lambda _: NOTHING), spec.drive.acceleration_m_s2
    top, speeds = spec.drive.top_speed_m_s, []
    for _ in range(200):
        speeds.append(rolling.drive(top)[0])
        left = WALL_AT - rolling.pose.x - spec.footprint_radius_m - SIDE_MARGIN_M
        assert speeds[-1] ** 2 / (2.0 * braking) <= left + 1e-6
    assert speeds[0] == top
    assert left < 0.03  # and it gets near


def test_held_back_it_gains_speed_no_faster_than_it_can(spec: RobotFile) -> None:
    """The driving primitive does not know of it and keeps commanding full speed."""
    ahead = [np.array([[spec.footprint_radius_m + 0.02, 0.0]])]
    rolling, top = Rolling(spec, 1.0, lambda _: ahead[0]), spec.drive.top_speed_m_s
    rolling.base.drive(0.0, 0.0)
    assert rolling.drive(top)[0] < 0.2 * top
    _, held = rolling.base.taken()
    assert held is not None
    assert held.shown_by == "scan"
    ahead[0] = NOTHING
    speeds = [rolling.drive(top)[0] for _ in range(60)]
    most = spec.drive.acceleration_m_s2 * spec.period_s + 1e-9
    assert speeds[0] < 0.3 * top
    assert np.diff(speeds).max() <= most
    assert speeds[-1] == top


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_held_back_it_keeps_the_direction_of_its_command(spec: RobotFile, way: float) -> None:
    """Forwards and backwards: the passed command never has the other sign, and reaches full speed."""
    near = [np.array([[way * (spec.footprint_radius_m + 0.02), 0.0]])]
    rolling, top = Rolling(spec, 2.5, lambda _: near[0]), spec.drive.top_speed_m_s
    rolling.base.drive(0.0, 0.0)
    speeds = [rolling.drive(way * top)[0] for _ in range(3)]
    near[0] = NOTHING
    speeds += [rolling.drive(way * top)[0] for _ in range(40)]
    assert all(way * speed >= 0.0 for speed in speeds)
    assert abs(speeds[3]) < 0.3 * top
    assert speeds[-1] == way * top


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_car_held_back_keeps_direction_and_curve(way: float) -> None:
    spec = load_robot("el_verde")
    near = [np.array([[way * (spec.footprint_radius_m + 0.02), 0.0]])]
    rolling, speed = Rolling(spec, 1.5, lambda _: near[0]), spec.drive.top_speed_m_s
    turn = 0.5 * spec.drive.sharpest_per_m * speed
    rolling.base.drive(0.0, 0.0)
    rolling.drive(way * speed, turn)
    near[0] = NOTHING
    passed = [rolling.drive(way * speed, turn) for _ in range(5)]
    assert all(way * forward > 0.0 for forward, _ in passed)
    assert [turned / forward for forward, turned in passed] == pytest.approx([way * turn / speed] * 5)


def test_it_keeps_off_what_it_ran_into_and_can_leave(spec: RobotFile) -> None:
    rolling, top = Rolling(spec, 2.0, lambda _: NOTHING), spec.drive.top_speed_m_s
    rolling.drive(0.1)
    bump = np.array([[*rolling.pose]])
    rolling.base.keep_off(bump_fronts(bump, spec.footprint_radius_m))
    assert rolling.drive(top)[0] == 0.0
    _, held = rolling.base.taken()
    assert held is not None
    assert held.shown_by == "contact"
    assert "it ran into something at (2." in held.words
    for _ in range(20):
        assert rolling.drive(-0.3)[0] < 0.0


def test_it_does_not_creep_nearer_to_a_wall_than_where_it_began(spec: RobotFile) -> None:
    begun = WALL_AT - spec.footprint_radius_m + 0.03  # too near: it may leave, and come back
    rolling = Rolling(spec, begun, lambda _: NOTHING)
    for speed in (0.1, -0.1, 0.1, -0.1, 0.1):
        for _ in range(20):
            rolling.drive(speed)
            assert rolling.pose.x <= begun + 0.016
    rolling.base.starts_here()
    rolling.drive(0.05)
    assert rolling.pose.x <= begun + 0.016


def test_a_car_that_is_slowed_stays_on_its_curve() -> None:
    spec = load_robot("el_verde")
    assert spec.drive.kind == "ackermann"
    ahead = np.array([[spec.footprint_radius_m + 0.15, 0.0]])
    rolling, speed = Rolling(spec, 1.0, lambda _: ahead), spec.drive.top_speed_m_s
    turn = 0.5 * spec.drive.sharpest_per_m * speed
    slowed, turned = rolling.drive(speed, turn)
    assert 0.0 < slowed < speed
    assert turned / slowed == pytest.approx(turn / speed)


def test_a_lone_reading_is_noise_two_beside_each_other_are_not() -> None:
    angles = np.linspace(-math.pi, math.pi, 360, endpoint=False)
    ranges = np.full(360, 3.0)
    ranges[100], ranges[200:202], ranges[300] = 0.4, 0.5, 9.0
    seen = np.hypot(*steady_points(Scan(angles, ranges, Pose2(0.0, 0.0, 0.0))).T)
    assert np.sort(seen)[:3] == pytest.approx([0.5, 0.5, 3.0])
    assert seen.max() == pytest.approx(3.0)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("room", "share"),
    [
        (0.391, 1.0),
        (0.389, 0.7),
        (0.2, 0.7),
        (0.19, 0.45),
        (0.1, 0.45),
        (0.08, 0.25),
        (0.04, 0.25),
        (0.02, 0.1),
    ],
)
def test_it_is_slowed_to_the_largest_share_that_can_brake(
    spec: RobotFile, way: float, room: float, share: float
) -> None:
    """From 0.6 m/s it stops after 30 mm in this period and 360 mm of braking; 5 mm beside it stay free."""
    wall = np.array([[way * (spec.footprint_radius_m + SIDE_MARGIN_M + room), 0.0]])
    rolling = Rolling(spec, 1.0 if way > 0.0 else 2.5, lambda _: wall)
    rolling.base.drive(0.0, 0.0)
    assert rolling.drive(way * 0.6)[0] == pytest.approx(way * share * 0.6)


def test_what_was_commanded_is_told_once(spec: RobotFile) -> None:
    rolling = Rolling(spec, 1.0, lambda _: NOTHING)
    rolling.base.drive(0.2, 0.3)
    assert rolling.base.taken() == (DriveCommand(0.2, 0.3), None)
    assert rolling.base.taken() == (DriveCommand(), None)


@pytest.mark.parametrize(("speed", "turn"), [(math.nan, 0.1), (0.1, math.inf), (0.0, 0.5)])
def test_what_is_no_way_is_passed_on_as_it_is(spec: RobotFile, speed: float, turn: float) -> None:
    """The backend below refuses what is not finite; turning in place sweeps over nothing."""
    near = np.array([[spec.footprint_radius_m + 0.001, 0.0]])
    rolling = Rolling(spec, 1.0, lambda _: near)
    rolling.base.drive(speed, turn)
    assert rolling.wheels.command == pytest.approx((speed, turn), nan_ok=True)


class SeenBy:
    """A scan that changes."""

    def __init__(self, seen: list[FloatArray]) -> None:
        self._seen = seen

    def __call__(self, pose: Pose2) -> FloatArray:
        return self._seen[0]


def test_a_base_that_is_held_still_turns_and_a_car_does_not() -> None:
    for name, turns in (("librarian", True), ("el_verde", False)):
        spec, seen = load_robot(name), [NOTHING]
        rolling = Rolling(spec, 1.0, SeenBy(seen))
        rolling.drive(0.01)
        seen[0] = np.array([[spec.footprint_radius_m - 0.03, 0.0]])
        assert rolling.drive(spec.drive.top_speed_m_s, 0.1) == (0.0, 0.1 if turns else 0.0)


@pytest.mark.parametrize(("count", "points"), [(0, 0), (1, 1), (2, 1), (3, 0)])
def test_beams_are_compared_with_neighbours_from_three_on(count: int, points: int) -> None:
    ranges = np.full(count, np.inf)
    ranges[:1] = 0.4
    scan = Scan(np.linspace(0.0, 0.2, count), ranges, Pose2(0.0, 0.0, 0.0))
    assert len(steady_points(scan)) == points


def test_share_of_the_speed_that_people_leave_is_of_one_period(spec: RobotFile) -> None:
    rolling = Rolling(spec, 1.0, lambda _: NOTHING)
    walker = BodyTrack(1, np.array([2.0, 5.0]), np.array([-1.2, 0.0]), 0.01 * np.eye(4), 0.25, True, 0.0)
    rolling.base.keep_off_people(People.of([walker]))
    assert rolling.drive(0.3) == (0.0, 0.0)
    rolling.base.taken()
    assert rolling.base.share_for_people == 0.0
    assert rolling.base.yields
    rolling.drive(0.3)
    rolling.base.taken()
    assert rolling.base.share_for_people == 1.0
    assert not rolling.base.yields


@pytest.mark.parametrize(("sigma_mm", "passes"), [(5.0, True), (30.0, False)])
def test_polygon_keeps_off_by_the_noise_of_its_lidar(spec: RobotFile, sigma_mm: float, passes: bool) -> None:
    """An obstacle is 20 mm beside the path of a rectangle's corner."""
    rectangle = FootprintSpec(rectangle_m=(0.6, 0.4))
    assert spec.range_sensor is not None
    noisy = spec.range_sensor.model_copy(update={"sigma_mm": sigma_mm})
    spec = spec.model_copy(update={"footprint": rectangle, "range_sensor": noisy})
    beside = np.array([[0.6, 0.22], [0.61, 0.22]])
    rolling = Rolling(spec, 2.0, lambda pose: beside - [pose.x - 2.0, 0.0])
    for _ in range(100):
        rolling.drive(0.3)
    assert (rolling.pose.x > 2.9) is passes
