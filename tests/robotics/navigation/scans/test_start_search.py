"""Search of the complete map by the first scan, for a robot that was set down at a wrong place."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField
from handcart.robotics.navigation.scans.start_search import ScanBeams, check_start, map_ranges

from ..conftest import ANGLES, Boxes

NOISE = 0.018
ROOM = [
    (4.0, 0.0, 0.0, 8.0, 0.1),
    (4.0, 6.0, 0.0, 8.0, 0.1),
    (0.0, 3.0, 0.0, 0.1, 6.0),
    (8.0, 3.0, 0.0, 0.1, 6.0),
]


def seen(boxes: Boxes, pose: Pose2, reach: float = 12.0) -> ScanBeams:
    """The beams of a lidar at a pose, with its noise."""
    ranges = box_ranges(boxes, pose, ANGLES) + np.random.default_rng(0).normal(0.0, 0.01, len(ANGLES))
    return ScanBeams(np.zeros(2), ANGLES, np.where(ranges < reach, ranges, np.inf), reach)


@pytest.mark.slow
@pytest.mark.parametrize(
    "off", [(0.8, 0.3, 0.0), (-0.6, 0.4, math.pi / 2), (0.0, 0.0, math.pi), (4.0, 0.5, 1.0)]
)
def test_a_wrong_start_is_corrected_where_the_map_tells(
    off: tuple[float, float, float], library_boxes: Boxes, library_field: LikelihoodField
) -> None:
    truth = Pose2(3.0, 3.5, 1.0)
    fit = check_start(library_field, seen(library_boxes, truth), truth.compose(Pose2(*off)), NOISE)
    assert fit.is_sure
    assert fit.other is not None
    assert fit.other.distance(truth) < 0.03
    assert fit.other.turn(truth) < 0.01


@pytest.mark.slow
def test_a_right_start_among_unknown_boxes_is_kept(
    library_boxes: Boxes, library_field: LikelihoodField
) -> None:
    truth = Pose2(3.0, 3.5, 1.0)
    boxes = [*library_boxes, (4.4, 3.1, 0.3, 0.3, 0.3), (2.2, 3.0, 0.0, 0.3, 0.8), (3.4, 4.1, 0.8, 0.4, 0.2)]
    fit = check_start(library_field, seen(boxes, truth), truth, NOISE)
    assert fit.share < 0.93  # so that other places were looked for
    assert not fit.contradicts


def test_a_room_that_looks_alike_both_ways_leaves_it_open() -> None:
    """Half a turn away everything looks the same: neither place is taken."""
    field = LikelihoodField(from_boxes(ROOM, 0.05, (-0.5, -0.5), (9.0, 7.0)))
    fit = check_start(field, seen(ROOM, Pose2(2.0, 2.0, 0.3)), Pose2(3.2, 2.6, 0.3), NOISE)
    assert fit.contradicts
    assert not fit.is_sure


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "stated"),
    [
        (Pose2(8.67, -0.351, 1.971), Pose2(9.068, -1.325, 1.534)),
        (Pose2(7.986, 0.426, 1.866), Pose2(8.599, -0.135, 2.402)),
    ],
)
def test_near_equal_poses_of_a_corridor_hide_no_better_one(truth: Pose2, stated: Pose2) -> None:
    """24 candidates were all along the corridor, and the true pose was none of them."""
    walls = [(30.0, y, 0.0, 60.0, 0.1) for y in (1.6, -1.6)] + [(x, 0.0, 0.0, 0.1, 3.2) for x in (0.0, 60.0)]
    boxes = [*walls, (4.0, 1.3, 0.0, 0.6, 0.6)]
    field = LikelihoodField(from_boxes(boxes, 0.05, (-1.0, -2.5), (62.0, 5.0)))
    fit = check_start(field, seen(boxes, truth, reach=8.0), stated, NOISE)
    assert fit.other is not None
    assert fit.other.distance(truth) < 0.05
    assert fit.other.turn(truth) < 0.01


def test_a_wall_that_does_not_return_contradicts_a_start() -> None:
    """Along a corridor only the end wall distinguishes places; if it is not seen where expected, the start is
    wrong.
    """
    walls = [(20.0, 1.5, 0.0, 40.0, 0.1), (20.0, -1.5, 0.0, 40.0, 0.1), (0.0, 0.0, 0.0, 0.1, 3.0)]
    field = LikelihoodField(from_boxes(walls, 0.05, (-1.0, -2.0), (42.0, 4.0)))
    beams = seen(walls, Pose2(6.0, 0.0, 0.0), reach=4.0)
    assert check_start(field, beams, Pose2(3.5, 0.0, 0.0), NOISE).contradicts
    assert not check_start(field, beams, Pose2(7.0, 0.0, 0.0), NOISE).contradicts


def test_ranges_on_a_map_are_those_to_its_walls(library: GridMap, library_boxes: Boxes) -> None:
    field, pose = LikelihoodField(library), Pose2(3.0, 3.5, 0.4)
    exact = box_ranges(library_boxes, pose, ANGLES)
    off = np.abs(map_ranges(field, pose, ANGLES, 20.0) - exact)
    assert np.median(off) < 0.04
    assert np.quantile(off, 0.9) < 0.12
    assert np.isinf(map_ranges(field, pose, ANGLES[exact > 2.1], 2.0)).mean() > 0.95
