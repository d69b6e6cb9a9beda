"""Tests of the number of missing echoes at which a lidar counts as covered."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.scan import Scan
from handcart.backends.description.range_spec import RangeSpec
from handcart.primitives.driving.lidar_watch import LidarWatch
from handcart.primitives.outcomes.discrepancy import NeedsPerson
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.expected_echoes import expected_echoes
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap, from_boxes

BEAMS = 360
ANGLES = np.radians(np.arange(BEAMS) - 180.0)
ROOM = from_boxes(
    [FloorBox(*item) for item in ((0, 3, 0, 6, 0.2), (0, -3, 0, 6, 0.2), (3, 0, 0, 0.2, 6))],
    0.05,
    (-4.0, -4.0),
    (8.0, 8.0),
)


def robot_of(pose: Pose2, ranges: np.ndarray, now: float) -> Any:
    """A robot whose lidar reads `ranges` in its middle."""
    scan = Scan(ANGLES, ranges, Pose2(0.0, 0.0, 0.0))
    spec = RangeSpec(beams=BEAMS, reach_m=8.0, sigma_mm=10.0)
    lidar = SimpleNamespace(scan=lambda: scan, spec=spec, blockage="", blind_share=0.0)
    return SimpleNamespace(lidar=lidar, pose=pose, time=now, localization=SimpleNamespace(stale_s=0.0))


@pytest.mark.parametrize(("width_deg", "said"), [(20, True), (19, False)])
def test_twenty_beams_that_must_return_are_enough(width_deg: int, said: bool) -> None:
    """A wall that so many beams meet, and none returns."""
    half = math.tan(math.radians(0.5 * width_deg)) * 3.0
    wall = from_boxes([FloorBox(3.0, 0.0, 0.0, 0.02, 2.0 * half - 0.03)], 0.01, (-4.0, -4.0), (8.0, 8.0))
    watch, silent = LidarWatch(), np.full(BEAMS, np.inf)

    def look() -> None:
        for second in range(4):
            watch.watch(
                robot_of(Pose2(0.0, 0.0, math.radians(0.5 * (width_deg % 2 == 0))), silent, 2.0 * second),
                wall,
            )

    if said:
        with pytest.raises(NeedsPerson, match="of 20 beams that meet a wall of the map"):
            look()
    else:
        look()


def ranges_at(pose: Pose2, grid: GridMap) -> np.ndarray:
    """Return the ranges of a lidar without faults."""
    return expected_echoes(grid, pose, ANGLES, 8.0).ranges


def drive_about(blind: Callable[[Pose2], np.ndarray]) -> None:
    """Turn on the spot and drive in the room; `blind` says which beams read nothing (n,)."""
    watch = LidarWatch()
    for look in range(24):
        pose = Pose2(-1.0 + 0.08 * look, 0.5, math.radians(15.0 * look))
        ranges = np.where(blind(pose), np.inf, ranges_at(pose, ROOM))
        watch.watch(robot_of(pose, ranges, 1.01 * look), ROOM)


def test_a_half_that_reads_zeros_is_found() -> None:
    with pytest.raises(NeedsPerson, match=r"the lidar is covered at .* degrees: of \d+ beams at walls"):
        drive_about(lambda pose: np.sin(ANGLES) > 0.0)


def test_a_covered_sector_of_60_degrees_is_found() -> None:
    with pytest.raises(NeedsPerson, match=r"the lidar is covered at (30 to 60|60 to 90) degrees"):
        drive_about(lambda pose: np.abs(ANGLES - math.radians(60.0)) < math.radians(31.0))


def test_walls_that_hang_above_the_scan_are_no_fault() -> None:
    """Two of the three walls return nothing, from wherever they are looked at."""
    height, width = ROOM.occupied.shape
    silent = np.zeros_like(ROOM.occupied)
    silent[: height // 3], silent[:, -width // 4 :] = True, True

    def hidden(pose: Pose2) -> np.ndarray:
        found = expected_echoes(ROOM, pose, ANGLES, 8.0)
        return np.where(found.met, silent.ravel()[found.cells], True)

    drive_about(hidden)


def test_a_lidar_that_sees_all_is_not_covered() -> None:
    drive_about(lambda pose: np.zeros(BEAMS, dtype=np.bool_))


def test_beams_that_fail_at_random_are_not_covered() -> None:
    rng = np.random.default_rng(3)
    drive_about(lambda pose: rng.random(BEAMS) < 0.8)
