"""Wheels that turn while something holds the base: scans deny them, and the pose stays where the base is."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.capabilities.range_sensor import Scan
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.held_base import HeldBase
from handcart.backends.robot.localization.lidar import Lidar
from handcart.backends.robot.localization.localizations import localization_of
from handcart.robotics.geometry.pose2 import Pose2

from .sensor_stubs import STANDS, START, Room, Stub, Wheels, room

STEP_M = 0.02
DRIVES = DriveCommand(0.4, 0.0)


class NoisyRoom(Room):
    """Lidar with the noise of a real one: the scans of a base at rest differ, too."""

    def __init__(self) -> None:
        super().__init__()
        self._rng = np.random.default_rng(5)

    def scan(self) -> Scan:
        scan = super().scan()
        return scan._replace(ranges=scan.ranges + self._rng.normal(0.0, 0.005, len(scan.ranges)))


class Drive:
    """Base in a room that drives 20 mm a period by its wheels, and moves by a share of it."""

    def __init__(self, localizer: str) -> None:
        self.wheels, self.lidar = Wheels(), NoisyRoom()
        spec = load_robot("cart").model_copy(update={"localizer": localizer})
        backend = Stub(self.wheels, self.lidar)
        self.found = localization_of(backend, spec, START, room(), Lidar(self.lidar, spec))
        for _ in range(10):
            self.found.update(STANDS)

    @property
    def watch(self) -> HeldBase:
        return self.found.held_base

    def roll(self, periods: int, share: float) -> None:
        for _ in range(periods):
            self.wheels.roll(STEP_M, STEP_M)
            self.lidar.pose = self.lidar.pose.compose(Pose2(share * STEP_M, 0.0, 0.0))
            self.found.update(DRIVES)

    @property
    def error_m(self) -> float:
        return self.found.pose.distance(self.lidar.pose)


@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_held_base_is_where_its_scans_show_it(localizer: str) -> None:
    """After 0.6 m by the wheels, of which it moved 0.2 m and then nothing."""
    drive = Drive(localizer)
    drive.roll(10, share=1.0)
    assert drive.watch.is_settled
    assert not drive.watch.searches
    drive.roll(20, share=0.0)
    assert drive.error_m < 0.07
    assert drive.found.pose.distance(START) < 0.27


@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_base_that_rolls_freely_is_never_denied(localizer: str) -> None:
    drive = Drive(localizer)
    for _ in range(12):
        drive.roll(5, share=0.98)
        assert drive.watch.is_settled
    assert drive.found.pose.distance(START) == pytest.approx(1.2, abs=0.06)
    assert drive.error_m < 0.05


def test_denied_wheels_are_believed_again_once_a_scan_shows_the_pose() -> None:
    drive = Drive("scan")
    drive.roll(15, share=0.0)
    drive.roll(25, share=1.0)
    assert drive.watch.is_settled
    assert drive.found.lost is None
    assert drive.error_m < 0.03


def test_search_for_a_held_base_ends_with_a_scan_at_rest() -> None:
    """By its wheels alone, no scan of a driven base shows where it is."""
    drive = Drive("odometry")
    assert drive.watch.compares_scans
    drive.roll(15, share=0.0)
    assert drive.watch.searches
    assert not drive.watch.is_settled
    assert drive.found.lost is None
    for _ in range(10):
        drive.found.update(STANDS)
    assert drive.watch.is_settled
    assert not drive.watch.searches
    assert drive.error_m < 0.03
