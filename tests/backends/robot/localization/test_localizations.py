"""Choice of a robot's localization, and its results from the readings of stub sensors."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.backends.capabilities.base import DriveCommand, WheelTravel
from handcart.backends.capabilities.beacons import BeaconRanges
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gps import Fix
from handcart.backends.capabilities.missing_capability import MissingCapability
from handcart.backends.capabilities.positioning import PoseReading
from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.localization.localization import Localization
from handcart.backends.robot.localization.outdoor_localization import OutdoorLocalization
from handcart.backends.robot.localization.pose_covariance import repeatability_of, worst_sigmas
from handcart.backends.robot.localization.positioning_localization import PositioningLocalization
from handcart.backends.robot.localization.wheel_localization import WheelLocalization
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.odometry_localizer import OdometryLocalizer
from handcart.robotics.navigation.outdoors.field_localizer import Inconsistency
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gyro_only import GyroOnly
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

from .sensor_stubs import (
    GRAVITY,
    STANDS,
    START,
    START_VARIANCES,
    Ceiling,
    Gyros,
    Radio,
    Receiver,
    Room,
    Stub,
    Wheels,
    made,
    room,
)


@pytest.mark.parametrize(
    ("name", "localizer", "parts", "has_map", "kind"),
    [
        ("cart", "scan", [Room], True, "ScanLocalization"),
        ("cart", "scan", [Room], False, "WheelLocalization"),
        ("cart", "scan", [], True, "WheelLocalization"),
        ("cart", "odometry", [Room], True, "WheelLocalization"),
        ("atrv", "positioning", [Ceiling, Room], True, "PositioningLocalization"),
        ("atrv", "positioning", [Room], True, "ScanLocalization"),
        ("cart", "positioning", [Ceiling, Room], True, "ScanLocalization"),
        ("atrv", "odometry", [Ceiling, Room], True, "WheelLocalization"),
        ("el_verde", "gyro", [Gyros, Room], True, "OutdoorLocalization"),
        ("el_verde", "gps_filter", [Gyros, Receiver], False, "OutdoorLocalization"),
    ],
)
def test_a_localization_needs_what_its_sensors_need(
    name: str, localizer: str, parts: list[Callable[[], Capability]], has_map: bool, kind: str
) -> None:
    found = made(name, localizer, Wheels(), *(one() for one in parts), grid=room() if has_map else None)
    assert type(found).__name__ == kind
    assert found.dead_reckoned == (kind == "WheelLocalization" or localizer == "gyro")


def test_a_start_is_as_sure_as_a_task_says() -> None:
    found = made("cart", "odometry", Wheels())
    assert found.pose == START
    assert found.covariance == pytest.approx(np.diag(START_VARIANCES))
    assert made("atrv", "positioning", Wheels(), Ceiling()).covariance == pytest.approx(
        np.diag(START_VARIANCES)
    )
    scanned = made("cart", "scan", Wheels(), Room(), grid=room())
    assert scanned.covariance[0, 0] < 0.02**2


def test_still_counts_periods_in_which_wheels_stand() -> None:
    wheels = Wheels()
    found, seen = made("cart", "odometry", wheels), []
    for way in (0.0, 0.0, 1e-3, 0.0, 1.5e-4, -1.5e-4, 3e-4, 0.0):
        wheels.roll(way, 0.5 * way)
        found.update(STANDS)
        seen.append(found.still)
    assert seen == [1, 2, 0, 1, 2, 3, 0, 1]
    assert found.travel[:2] == pytest.approx((1.3e-3, 6.5e-4))


def test_a_reading_that_is_not_finite_is_made_up_for_by_the_next() -> None:
    wheels = Wheels()
    found = made("cart", "odometry", wheels)
    for reading in (WheelTravel(math.nan, 0.1), WheelTravel(0.1, math.inf)):
        wheels.travel = reading
        found.update(STANDS)
        assert found.pose == START
    wheels.travel = WheelTravel(0.2, 0.2)
    found.update(STANDS)
    assert found.pose == pytest.approx(START.compose(Pose2(0.2, 0.0, 0.0)))


@pytest.mark.parametrize("driven", [(0.16, 0.0), (-0.16, 0.0), (0.0, -0.64), (0.08, 0.32)])
def test_wheels_that_do_not_answer_are_lost_after_3_cm(driven: tuple[float, float]) -> None:
    """Each is 8 mm a period: of a tread of 0.5 m half times the turn rate is the way of a wheel."""
    wheels, lost = Wheels(), []
    found = made("cart", "odometry", wheels)
    assert isinstance(found, WheelLocalization)
    for _ in range(4):
        found.update(DriveCommand(*driven))
        lost.append(found.lost)
    assert lost[:3] == [None] * 3
    assert lost[3] is not None
    assert (lost[3].value, lost[3].limit) == pytest.approx((32.0, 30.0))
    assert lost[3].unit == "mm"
    assert lost[3].sensor == "Base"
    assert found.sigma == (math.inf, math.inf)
    wheels.roll(1e-4, 0.0)
    found.update(DriveCommand(*driven))
    assert found.lost is None
    assert found.sigma == worst_sigmas(found.covariance)


def test_a_measured_pose_is_as_sure_as_it_was_measured() -> None:
    found = made("cart", "odometry", Wheels())
    found.found_at(Pose2(2.01, 3.02, 0.51), (0.004, 0.002))
    assert found.pose == (2.01, 3.02, 0.51)
    assert found.covariance == pytest.approx(np.diag([0.004**2, 0.004**2, 0.002**2]))


def test_sigmas_are_along_the_worst_direction() -> None:
    covariance = np.array([[5.0, 4.0, 0.0], [4.0, 5.0, 0.0], [0.0, 0.0, 0.25]])
    assert worst_sigmas(covariance) == pytest.approx((3.0, 0.5))
    scatter = np.diag([0.004**2, 0.004**2, 0.0015**2])
    shared = np.diag([1.0, 0.5, 0.05])
    assert repeatability_of(covariance, shared) == pytest.approx(covariance - shared + scatter)
    assert repeatability_of(shared, 2.0 * shared) == pytest.approx(scatter)


def outdoors(
    *parts: Capability, filtering: GyroOnly | None = None
) -> tuple[OutdoorLocalization, Wheels, Gyros]:
    wheels, gyros = Wheels(), Gyros()
    field = LikelihoodField(room())
    odometry = OdometryLocalizer(START, 0.6, covariance=np.diag(START_VARIANCES), field=field)
    filtering = GyroOnly(START, REFERENCE_NOISE, 0.05) if filtering is None else filtering
    return OutdoorLocalization(Stub(wheels, gyros, *parts), odometry, filtering), wheels, gyros


@pytest.mark.slow
@pytest.mark.parametrize("broken", [False, True])
def test_gyros_that_read_the_same_are_lost_after_15_cm(broken: bool) -> None:
    found, wheels, gyros = outdoors()
    found.update(STANDS)
    wheels.roll(1.0, 1.0)
    found.update(STANDS)
    assert found.lost is None
    gyros.stuck, gyros.broken = not broken, broken
    for way in (0.1, 0.04):
        wheels.roll(way, -way)
        found.update(STANDS)
        assert found.lost is None
    wheels.roll(0.02, 0.0)
    found.update(STANDS)
    lost = found.lost
    assert lost is not None
    assert (lost.sensor, lost.value, lost.limit, lost.unit) == ("Imu", pytest.approx(160.0), 150.0, "mm")
    assert found.doubt == lost
    gyros.stuck, gyros.broken = False, False
    found.update(STANDS)
    assert found.lost is None


def test_outdoors_wheels_carry_the_pose_that_scans_look_near() -> None:
    found, wheels, _ = outdoors()
    for _ in range(5):
        wheels.roll(0.05, 0.05)
        found.update(STANDS)
    carried = START.compose(Pose2(0.25, 0.0, 0.0))
    assert found._wheels.pose == pytest.approx(carried)
    assert found.pose == pytest.approx(carried, abs=1e-3)
    assert found.odometry_pose == pytest.approx(carried, abs=1e-3)


def test_what_was_sensed_is_told_as_it_came() -> None:
    receiver, radio = Receiver(), Radio()
    found, wheels, _ = outdoors(receiver, radio)
    assert found.sensed.fix is None
    assert found.sensed.rolled.tolist() == [0.0, 0.0]
    receiver.now, radio.now = Fix(np.array([1.0, 2.0]), 0.5), BeaconRanges(np.array([3.0, math.nan]))
    wheels.roll(0.1, 0.2)
    found.update(STANDS)
    assert found.sensed.fix is receiver.now
    assert found.sensed.rolled.tolist() == pytest.approx([0.1, 0.2])
    assert found.sensed.accelerations.tolist() == GRAVITY.tolist()
    assert found.sensed.rates[2] > 0.0
    assert found.sensed.ranges is not None
    assert found.sensed.ranges[0] == 3.0
    receiver.now, radio.now = None, None
    found.update(STANDS)
    assert found.sensed.fix is None
    assert found.sensed.ranges is None


class Asked(GyroOnly):
    """A filter that keeps its inputs, and contradicts itself on request."""

    found: Inconsistency | None = None

    def __init__(self, fixes: bool, ranges: bool) -> None:
        super().__init__(START, REFERENCE_NOISE, 0.05)
        self.TAKES_FIXES, self.TAKES_RANGES = fixes, ranges  # type: ignore[misc]
        self.given: list[list[float]] = []

    @property
    def inconsistency(self) -> Inconsistency | None:
        return self.found

    def fix(self, position: np.ndarray, sigma: float | None = None) -> bool:
        self.given.append(position.tolist())
        return True

    def ranges(self, distances: np.ndarray) -> None:
        self.given.append(distances.tolist())


@pytest.mark.parametrize("fixes", [False, True])
@pytest.mark.parametrize("ranges", [False, True])
@pytest.mark.parametrize("has_gps", [False, True])
@pytest.mark.parametrize("has_radio", [False, True])
def test_outdoors_only_readings_that_count_end_dead_reckoning(
    fixes: bool, ranges: bool, has_gps: bool, has_radio: bool
) -> None:
    parts = [part() for part, there in ((Receiver, has_gps), (Radio, has_radio)) if there]
    found, _, _ = outdoors(*parts, filtering=Asked(fixes, ranges))
    assert found.dead_reckoned == (not (fixes and has_gps) and not (ranges and has_radio))


@pytest.mark.parametrize(("ranges", "sensor", "what"), [(True, "Beacons", "ranges"), (False, "Gps", "fixes")])
def test_readings_that_contradict_the_claim_are_a_doubt(ranges: bool, sensor: str, what: str) -> None:
    filtering = Asked(not ranges, ranges)
    found, _, _ = outdoors(Radio() if ranges else Receiver(), filtering=filtering)
    assert found.doubt is None
    filtering.found = Inconsistency("share", 0.7, 0.5)
    doubt = found.doubt
    assert doubt is not None
    assert (doubt.sensor, doubt.what, doubt.value, doubt.limit) == (sensor, "share", 0.7, 0.5)
    assert doubt.why == f"the {what} of the last minute contradict what is claimed"
    assert found.lost is None


def test_fixes_and_ranges_reach_the_filter_once() -> None:
    receiver, radio, filtering = Receiver(), Radio(), Asked(True, True)
    found, _, _ = outdoors(receiver, radio, filtering=filtering)
    found.update(STANDS)
    receiver.now, radio.now = Fix(np.array([1.0, 2.0]), 0.5), BeaconRanges(np.array([3.0, 4.0]))
    found.update(STANDS)
    assert filtering.given == [[1.0, 2.0], [3.0, 4.0]]


def positioned() -> tuple[PositioningLocalization, Wheels, Ceiling]:
    wheels, ceiling = Wheels(), Ceiling()
    found = made("atrv", "positioning", wheels, ceiling)
    assert isinstance(found, PositioningLocalization)
    return found, wheels, ceiling


def test_a_positioning_reading_is_where_the_base_was_then() -> None:
    found, wheels, ceiling = positioned()
    for _ in range(4):
        wheels.roll(0.02, 0.02)
        found.update(STANDS)
    there = START.compose(Pose2(0.04, 0.01, 0.0))  # two periods ago, and 10 mm to the left
    ceiling.now = PoseReading(1, there, 0.1)
    found.update(STANDS)
    assert found.pose.distance(START.compose(Pose2(0.06, 0.01, 0.0))) < 1e-4
    assert found.displacements == 0


@pytest.mark.parametrize(
    "reading", [(math.nan, 0.0, 0.0, 0.0), (0.0, 0.0, math.inf, 0.0), (0.0, 0.0, 0.0, math.nan)]
)
def test_a_broken_positioning_reading_counts_nothing(reading: tuple[float, ...]) -> None:
    found, _, ceiling = positioned()
    ceiling.now = PoseReading(1, Pose2(*reading[:3]), reading[3])
    found.update(STANDS)
    assert found.pose == START
    assert found.covariance == pytest.approx(np.diag(START_VARIANCES))


@pytest.mark.parametrize(("standing", "moved"), [(0, 0), (1, 1)])
def test_a_base_was_moved_only_if_it_stood_when_measured(standing: int, moved: int) -> None:
    """By three readings that are two periods old, from the last period in which it rolled, or the next."""
    found, wheels, ceiling = positioned()
    elsewhere = START.compose(Pose2(0.0, 1.0, 0.0))
    for period in range(3 + standing):
        wheels.roll(*((0.001, 0.001) if period == 0 else (0.0, 0.0)))
        if period >= standing:
            ceiling.now = PoseReading(period + 1, elsewhere, 0.1)
        found.update(STANDS)
    assert found.pose.distance(elsewhere) < 0.01
    assert found.displacements == moved
    assert found.still == (0 if moved else 2)


def test_outdoor_localizer_without_gyros_is_refused_in_words() -> None:
    words = "the robot has no Imu, which `localizer: gyro` in the robot's file needs; it has: Base"
    with pytest.raises(MissingCapability, match=words):
        made("el_verde", "gyro", Wheels())


@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_lidar_that_repeats_its_scan_for_long_loses_the_pose(localizer: str) -> None:
    found = made("cart", localizer, Wheels(), Room(), grid=room())
    assert found.lost is None
    found.stale_s = 10.1
    assert found.lost is not None
    assert found.lost.why == "its lidar repeats its last scan"
    assert (found.lost.value, found.lost.limit, found.lost.unit) == (10.1, 10.0, "s")


@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_base_that_is_pushed_at_rest_is_found_again(localizer: str) -> None:
    lidar = Room()
    found = made("cart", localizer, Wheels(), lidar, grid=room())
    for _ in range(40):
        found.update(STANDS)
    assert found.displacements == 0
    lidar.pose = START.compose(Pose2(0.1, 0.05, 0.0))
    for _ in range(30):
        found.update(STANDS)
    assert found.displacements == 1
    assert found.pose == pytest.approx(lidar.pose, abs=0.02)


class Stalling(Room):
    """A lidar in a room, which repeats its scan while `stalls`, and gets no echoes while `is_silent`."""

    stalls = is_silent = False
    _last: Scan | None = None

    def scan(self) -> Scan:
        if self._last is None or not self.stalls:
            self._last = super().scan()
        nothing = np.full(len(self._last.ranges), np.inf)
        return self._last._replace(ranges=nothing) if self.is_silent else self._last


def driven_by_wheels(lidar: Stalling, stalls: bool) -> Localization:
    """Return the localization of a base that drove 0.6 m, of which it slipped 80 mm, as it comes to rest."""
    wheels = Wheels()
    found = made("cart", "odometry", wheels, lidar, grid=room())
    for _ in range(10):
        found.update(STANDS)
    for period in range(20):
        lidar.stalls = stalls and period > 15
        wheels.roll(0.03, 0.03)
        lidar.pose = lidar.pose.compose(Pose2(0.026, 0.0, 0.0))
        found.update(STANDS)
    return found


@pytest.mark.parametrize("periods", [4, 8, 30])
def test_lidar_that_stalls_at_the_stop_leaves_a_drive_unchecked(periods: int) -> None:
    """Until it returns a new scan, by which the pose is corrected at once."""
    lidar = Stalling()
    found = driven_by_wheels(lidar, stalls=True)
    for _ in range(periods):
        found.update(STANDS)
        assert found.added_sigma > 0.0
    assert found.pose.distance(lidar.pose) > 0.05
    lidar.stalls = False
    found.update(STANDS)
    assert found.added_sigma == 0.0
    assert found.pose.distance(lidar.pose) < 0.04


def test_drive_that_ends_where_nothing_is_seen_needs_no_scan() -> None:
    lidar = Stalling()
    found = driven_by_wheels(lidar, stalls=False)
    lidar.is_silent = True
    for _ in range(4):
        found.update(STANDS)
    assert found.added_sigma == 0.0
    assert found.slips == 0
