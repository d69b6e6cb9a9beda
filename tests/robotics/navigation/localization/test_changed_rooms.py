"""A localizer whose map differs from the room: its claim holds, or it reports that it is lost."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import ScanLocalizer
from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.odometry.odometry import Odometry, OdometryErrors
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

from ..conftest import Boxes

TREAD, STEP_M, REACH_M = 0.4, 0.03, 8.0
ANGLES = np.linspace(-math.pi, math.pi, 360, endpoint=False)
ROOM: Boxes = [(5.013, y, 0.0, 10.2, 0.1) for y in (0.017, 6.021)]
ROOM += [(x, 3.0, 0.0, 0.1, 6.1) for x in (0.011, 10.027)]
FURNITURE: Boxes = [(2.53, 4.81, 0.0, 1.2, 0.6), (7.21, 1.13, 0.3, 0.9, 0.7), (5.17, 5.27, 0.0, 0.6, 0.6)]
POSTS: Boxes = [(1.3 + 1.1 * k, 1.2 + 3.6 * (k % 2), 0.2 * k, 0.35, 0.35) for k in range(8)]
See = Callable[[Pose2, np.random.Generator], np.ndarray]


def ranges(boxes: Boxes, pose: Pose2) -> np.ndarray:
    return np.asarray(box_ranges(boxes, pose, ANGLES))


def plain(boxes: Boxes) -> See:
    return lambda pose, rng: ranges(boxes, pose)


def glass(pose: Pose2, rng: np.random.Generator) -> np.ndarray:
    """The upper wall is of glass: 40 % of the beams pass, and end at things 1.5 m behind it."""
    near = ranges([*ROOM, *FURNITURE], pose)
    beyond = ranges([ROOM[0], *ROOM[2:], *FURNITURE, (5.0, 7.52, 0.0, 12.0, 0.1)], pose)
    return np.where(rng.random(len(near)) < 0.4, beyond, near)


def mirror(pose: Pose2, rng: np.random.Generator) -> np.ndarray:
    """Half of the right wall is a mirror: reflections appear as far behind it as the things are before it."""
    x, low, high = 9.977, 2.0, 5.0
    near = ranges([*ROOM, *FURNITURE], pose)
    there = near * np.sin(ANGLES + pose.theta) + pose.y
    met = near * np.cos(ANGLES + pose.theta) + pose.x
    image = [
        (2.0 * x - bx, by, math.pi - yaw, length, width) for bx, by, yaw, length, width in [*ROOM, *FURNITURE]
    ]
    behind = ranges([item for k, item in enumerate(image) if k != 3], pose)
    return np.where((np.abs(met - x) < 0.02) & (there > low) & (there < high), behind, near)


def moved(pose: Pose2, rng: np.random.Generator) -> np.ndarray:
    """All furniture was moved by 0.5 m."""
    elsewhere = [(x + 0.5, y, yaw, length, width) for x, y, yaw, length, width in FURNITURE]
    return ranges([*ROOM, *elsewhere], pose)


def drive(mapped: Boxes, see: See, seed: int, resolution: float = 0.05) -> list[tuple[float, bool]]:
    """Errors in claimed sigmas at each second period of a drive with a bend, and whether it is lost."""
    rng = np.random.default_rng(seed)
    errors, start = OdometryErrors(radius=0.005, tread=0.01, slip=0.01), Pose2(2.0, 2.5, 0.0)
    field = LikelihoodField(from_boxes(mapped, resolution, (-2.0, -2.0), (14.0, 10.0)))
    spread = np.diag([0.03, 0.03, 0.02]) ** 2
    begun = Pose2(*(np.array(start) + rng.normal(0.0, 1.0, 3) * np.sqrt(np.diag(spread))).tolist())
    localizer = ScanLocalizer(field, begun, TREAD, errors, spread)
    scale = 1.0 + rng.normal(0.0, errors.radius, 2)
    truth, found = Odometry(start, TREAD, OdometryErrors(0.0, 0.0, 0.0)), []
    for period in range(150):
        bend = 0.5 * math.sin(period / 25.0) * STEP_M * TREAD / 2
        wheels = np.array([STEP_M - bend, STEP_M + bend])
        truth.predict(*(wheels * scale * (1.0 + rng.normal(0.0, errors.slip, 2))).tolist())
        localizer.predict(*wheels.tolist())
        seen = see(truth.pose, rng) + rng.normal(0.0, 0.01, len(ANGLES))
        hit = seen < REACH_M
        localizer.correct(seen[hit, None] * np.column_stack([np.cos(ANGLES[hit]), np.sin(ANGLES[hit])]))
        off = np.subtract(localizer.pose[:2], truth.pose[:2])
        squared = float(off @ np.linalg.solve(localizer.covariance[:2, :2], off))
        found.append((math.sqrt(squared), localizer.lost))
    return found[1::2]


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("mapped", "see"),
    [
        ([], plain([*ROOM, *POSTS])),
        (ROOM[:1], plain([*ROOM, *POSTS])),
        (ROOM, plain([*ROOM, *POSTS])),
        ([*ROOM, *FURNITURE], glass),
        ([*ROOM, *FURNITURE], mirror),
        ([*ROOM, *FURNITURE], moved),
    ],
    ids=["empty map", "one wall mapped", "half unmapped", "glass", "mirror", "moved furniture"],
)
def test_a_pose_in_a_changed_room_holds_its_claim(mapped: Boxes, see: See, seed: int) -> None:
    """A normal error in two dimensions is beyond 3.5 sigma at 2 of 1,000 places."""
    believed = [sigmas for sigmas, is_lost in drive(mapped, see, seed) if not is_lost]
    assert len(believed) > 60
    assert max(believed) < 3.5
