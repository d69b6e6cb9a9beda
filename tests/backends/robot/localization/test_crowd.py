"""People around a base at rest: which beams they hide, and which differences they do not excuse."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.localization.crowd import NO_DISCS, Crowd
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField

from .sensor_stubs import START, Room, room

STILL = Pose2(0.0, 0.0, 0.0)
PERSON = np.array([[4.0, 3.5, 0.4]])


def scan_from(pose: Pose2) -> Scan:
    sensor = Room()
    sensor.pose = pose
    return sensor.scan()


def crowd_at_rest(pose: Pose2 = START) -> Crowd:
    """Return a crowd with one person, of a base that came to rest at a pose."""
    crowd = Crowd()
    crowd.came_to_rest(scan_from(pose))
    crowd.put(PERSON)
    return crowd


def test_person_is_near_from_first_sight_until_base_moves() -> None:
    crowd = Crowd()
    assert not crowd.is_near
    crowd.put(PERSON)
    assert crowd.is_near
    crowd.put(NO_DISCS)
    crowd.passed()
    assert crowd.is_near
    crowd.moved()
    assert not crowd.is_near


def test_points_on_people_are_left_out_for_one_period() -> None:
    crowd, points = crowd_at_rest(), scan_from(START).points()
    there = START.inverse().apply(np.array([[4.0, 3.8], [4.0, 3.95]]))
    left = crowd.without(np.vstack([points, there]), START)
    assert left == pytest.approx(np.vstack([points, there[1:]]))
    crowd.passed()
    assert len(crowd.without(there, START)) == 2


def test_scan_of_people_alone_is_kept() -> None:
    crowd, count = crowd_at_rest(), 10
    near = np.tile(START.inverse().apply(PERSON[:, :2]), (count, 1))
    far = np.tile(START.inverse().apply(np.array([[7.0, 1.0]])), (count, 1))
    assert len(crowd.without(np.vstack([near, far[:4]]), START)) == count + 4
    assert len(crowd.without(np.vstack([near, far[:5]]), START)) == 5


@pytest.mark.parametrize("off", [0.03, 0.3])
def test_base_that_did_not_move_is_excused_by_people(off: float) -> None:
    """The map errs: it shows the walls where they would be seen from elsewhere."""
    believed = START.compose(Pose2(-off, 0.0, 0.0))
    field = LikelihoodField(room())
    assert crowd_at_rest().hides_walls(scan_from(START), believed, field, STILL)


@pytest.mark.parametrize("off", [0.03, 0.3])
def test_base_that_moved_is_not_excused_by_people(off: float) -> None:
    moved = START.compose(Pose2(off, 0.0, 0.0))
    field = LikelihoodField(room())
    assert not crowd_at_rest().hides_walls(scan_from(moved), START, field, STILL)


def test_wheels_that_rolled_as_far_as_seen_are_no_shift() -> None:
    """The pose is believed behind, the wheels report the way: the scan agrees with the wheels."""
    way = Pose2(0.03, 0.0, 0.0)
    field = LikelihoodField(room())
    assert crowd_at_rest().hides_walls(scan_from(START.compose(way)), START, field, way)


def test_nobody_excuses_nothing() -> None:
    crowd, field = crowd_at_rest(), LikelihoodField(room())
    believed = START.compose(Pose2(-0.03, 0.0, 0.0))
    assert not crowd.hides_walls(scan_from(START), believed, None, STILL)
    crowd.moved()
    assert not crowd.hides_walls(scan_from(START), believed, field, STILL)
