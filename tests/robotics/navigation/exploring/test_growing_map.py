"""A map that grows by keyframes: the same as from a log, in the frame of its start or of a given map."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.exploring.growing_map import GrowingMap
from handcart.robotics.navigation.mapping.scan_log import Keyframe, keyframe_of
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

WALLS = [(x, 0.0, 0.0, 0.1, 6.0) for x in (-1.0, 9.0)] + [(4.0, y, 0.0, 10.0, 0.1) for y in (-3.0, 3.0)]
WALLS += [(float(x), 2.4, 0.3, 0.6, 0.5) for x in range(0, 9, 2)]
ANGLES = np.radians(np.arange(-180.0, 180.0, 2.0))
HERE = Pose2(0.0, 0.0, 0.0)


def seen(number: int, at: Pose2, odometry: Pose2, rng: np.random.Generator) -> Keyframe:
    ranges = box_ranges(WALLS, at, ANGLES) + rng.normal(0.0, 0.01, len(ANGLES))
    return keyframe_of(number, odometry, (ANGLES, ranges), HERE, 20.0)


def driven(start: Pose2, known: GridMap | None = None, count: int = 20) -> tuple[GrowingMap, list[Pose2]]:
    """Drive 0.3 m a keyframe with wheels that turn 1 mrad and drive 2 % too far; the map and true poses."""
    rng = np.random.default_rng(4)
    true = [Pose2(0.3 * number, 0.0, 0.0) for number in range(count)]
    wheels = [Pose2(0.306 * number, 0.0, 0.001 * number) for number in range(count)]
    grown = GrowingMap(seen(0, true[0], wheels[0], rng), start, known)
    for number in range(1, count):
        grown.add(seen(number, true[number], wheels[number], rng))
    return grown, true


def test_scans_correct_the_wheels() -> None:
    grown, true = driven(HERE)
    assert grown.blind == 0
    assert grown.poses[-1].distance(true[-1]) < 0.02
    assert grown.pose_of(grown.last.odometry) == pytest.approx(grown.poses[-1])
    assert np.linalg.eigvalsh(grown.covariance())[-1] < 0.05**2
    built = grown.built(0.05)
    assert len(built.rows) == len(built.poses) == 20
    assert built.counts.grid.occupied.sum() > 100


def test_given_map_draws_the_poses_to_its_walls() -> None:
    """The start is 3 cm and 10 mrad off; the map shows it."""
    known = from_boxes(WALLS, 0.03, (-1.5, -3.5), (11.0, 7.0))
    off = Pose2(0.02, -0.02, 0.01)
    alone, true = driven(off)
    with_map, _ = driven(off, known)
    with_map.search()
    assert alone.poses[-1].distance(true[-1]) > 0.04
    assert with_map.poses[-1].distance(true[-1]) < 0.03
    assert with_map.grid(0.05).occupied.shape[1] * 0.05 >= 11.0


def test_pose_is_carried_on_from_where_the_base_was_found() -> None:
    grown, _ = driven(Pose2(1.0, 2.0, 0.0), count=3)
    odometry = grown.last.odometry
    grown.carry_on_from(odometry, Pose2(0.5, 0.0, 0.0))
    assert grown.pose_of(odometry) == pytest.approx(Pose2(1.5, 2.0, 0.0))
