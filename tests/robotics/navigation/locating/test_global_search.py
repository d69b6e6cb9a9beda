"""Search of a whole map for the poses that explain a scan."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.locating.beam_evidence import explain, independent_beams, matching_noise
from handcart.robotics.navigation.locating.global_search import same_place, search_map
from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.start_search import ScanBeams

from ..conftest import ANGLES, Boxes

REACH_M = 12.0
ROOM = [(4.0, y, 0.0, 8.0, 0.1) for y in (0.0, 6.0)] + [(x, 3.0, 0.0, 0.1, 6.0) for x in (0.0, 8.0)]


def seen(boxes: Boxes, pose: Pose2, reach: float = REACH_M) -> ScanBeams:
    """Return the beams of a lidar at a pose, with noise."""
    ranges = box_ranges(boxes, pose, ANGLES) + np.random.default_rng(0).normal(0.0, 0.01, len(ANGLES))
    return ScanBeams(np.zeros(2), ANGLES, np.where(ranges < reach, ranges, np.inf), reach)


@pytest.mark.parametrize("truth", [Pose2(3.0, 3.5, 1.0), Pose2(7.0, 1.2, -2.5), Pose2(10.5, 7.0, 3.0)])
def test_search_finds_the_pose_anywhere_on_a_map(
    truth: Pose2, library_boxes: Boxes, library_field: LikelihoodField
) -> None:
    noise = matching_noise(library_field, 0.01)
    found = search_map(library_field, seen(library_boxes, truth), noise)
    best = Pose2(*found.poses[0].tolist())
    assert best.distance(truth) < 0.03
    assert best.turn(truth) < 0.01


def test_search_finds_both_poses_of_a_symmetric_room() -> None:
    field, truth = LikelihoodField(from_boxes(ROOM, 0.05, (-0.5, -0.5), (9.0, 7.0))), Pose2(2.0, 2.0, 0.3)
    image = np.array([6.0, 4.0, 0.3 - math.pi])
    found = search_map(field, seen(ROOM, truth), matching_noise(field, 0.01))
    assert same_place(found.poses[:2], np.array(truth)).sum() == 1
    assert same_place(found.poses[:2], image).sum() == 1
    assert found.log_likelihoods[1] > found.log_likelihoods[0] - 3.0


def test_a_scan_without_echoes_finds_nothing(library_field: LikelihoodField) -> None:
    silent = ScanBeams(np.zeros(2), ANGLES, np.full(len(ANGLES), np.inf), REACH_M)
    assert not len(search_map(library_field, silent, 0.02).poses)


def test_beams_through_a_wall_count_more_than_short_ones() -> None:
    """An unmapped thing is more likely than a wall that has gone."""
    boxes = [*ROOM, (4.0, 4.5, 0.0, 1.0, 1.0)]
    truth = Pose2(4.0, 2.0, 0.0)
    without, with_box = (
        LikelihoodField(from_boxes(item, 0.05, (-0.5, -0.5), (9.0, 7.0))) for item in (ROOM, boxes)
    )
    short = explain(without, seen(boxes, truth), np.array([truth]), 0.02)
    through = explain(with_box, seen(ROOM, truth), np.array([truth]), 0.02)
    assert short.short[0] > 0.05 > short.through[0]
    assert through.through[0] > 0.05 > through.short[0]
    assert through.log_likelihood[0] < 1.5 * short.log_likelihood[0] < 0.0


def test_unknown_beams_are_no_evidence(library_field: LikelihoodField, library_boxes: Boxes) -> None:
    truth = Pose2(3.0, 3.5, 1.0)
    beams = seen(library_boxes, truth)
    half = np.where(np.arange(len(ANGLES)) < 180, np.nan, beams.ranges)
    fit = explain(library_field, beams._replace(ranges=half), np.array([truth]), 0.02)
    assert fit.explained[0] > 0.95
    assert independent_beams(beams._replace(ranges=half)) <= 21.0
