"""The heading in round rooms, which the staircase of a map's cells claims to determine."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_evidence import ScanEvidence, confirmed
from handcart.robotics.navigation.scans.scan_matching import match_scan
from handcart.robotics.navigation.scans.turn_evidence import TurnEvidence, without_turn

RADIUS_M, CELL_M, MIDDLE_M = 2.5, 0.05, 2.725
SIGMAS = np.array([0.05, 0.05, 0.1])
ANGLES = np.radians(np.arange(-180.0, 180.0))


def round_map(cell: float = CELL_M) -> GridMap:
    """Return the map of a round room, whose middle is at (MIDDLE_M, MIDDLE_M)."""
    count = round(2.0 * MIDDLE_M / cell)
    at = (np.arange(count) + 0.5) * cell - MIDDLE_M
    away = np.hypot(*np.meshgrid(at, at))
    wall = np.abs(away - RADIUS_M) < 0.6 * cell
    return GridMap(wall, np.zeros_like(wall), cell, 0.0, 0.0)


def round_points(pose: Pose2, rng: np.random.Generator) -> np.ndarray:
    """Return the end points of a scan in the base frame, of a wall that is round, not of cells."""
    x, y, heading = pose.x - MIDDLE_M, pose.y - MIDDLE_M, pose.theta + ANGLES
    along = x * np.cos(heading) + y * np.sin(heading)
    ranges = -along + np.sqrt(along**2 - (x * x + y * y - RADIUS_M**2)) + rng.normal(0.0, 0.01, len(ANGLES))
    return np.asarray(ranges[:, None] * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)]))


@pytest.mark.parametrize("cell", [0.05, 0.1])
def test_round_room_determines_no_heading(cell: float) -> None:
    """The prior's heading and its uncertainty stay, and the middle of the room is where it was seen."""
    field, rng = LikelihoodField(round_map(cell)), np.random.default_rng(1)
    errors = []
    for _ in range(12):
        x, y = MIDDLE_M + rng.uniform(-1.0, 1.0, 2)
        true = Pose2(x, y, rng.uniform(-3.0, 3.0))
        near = Pose2._make(np.array(true) + SIGMAS * rng.normal(size=3))
        match = match_scan(field, round_points(true, rng), near, np.diag(SIGMAS**2))
        assert match.evidence.turn_share == 0.0
        assert math.sqrt(match.covariance[2, 2]) > 0.04
        off = np.array(match.pose) - np.array(true)
        errors.append(float(off @ np.linalg.solve(match.covariance, off)))
        middle = np.array([[MIDDLE_M, MIDDLE_M]])
        seen = match.pose.inverse().apply(middle) - true.inverse().apply(middle)
        assert np.hypot(*seen[0]) < 0.02
    assert 0.5 < np.mean(errors) < 6.0  # of three degrees of freedom; by the slopes alone 425 and 101


def test_rectangular_room_determines_the_heading() -> None:
    boxes = [(2.0, 0.0, 0.0, 4.0, 0.1), (2.0, 3.0, 0.0, 4.0, 0.1), (0.0, 1.5, 0.0, 0.1, 3.1)]
    boxes.append((4.0, 1.5, 0.0, 0.1, 3.1))
    field, rng = (
        LikelihoodField(from_boxes(boxes, CELL_M, (-1.0, -1.0), (5.0, 4.0))),
        np.random.default_rng(2),
    )
    for _ in range(8):
        true = Pose2(rng.uniform(1.0, 3.0), rng.uniform(1.0, 2.0), rng.uniform(-3.0, 3.0))
        ranges = box_ranges(boxes, true, ANGLES) + rng.normal(0.0, 0.01, len(ANGLES))
        points = ranges[:, None] * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
        near = Pose2(true.x + 0.03, true.y - 0.03, true.theta + 0.05)
        match = match_scan(field, points, near, np.diag(SIGMAS**2))
        assert match.evidence.turn_share == 1.0
        assert abs(match.pose.theta - true.theta) < 0.01


def test_one_scan_alone_does_not_determine_a_heading_again() -> None:
    """As for the position: the previous scan has to agree."""
    seen = ScanEvidence(np.array([1.0, 0.0]), 1.0, turn_share=0.5)
    assert confirmed(seen, None).turn_share == 0.5
    assert confirmed(seen, seen).turn_share == 0.5
    assert confirmed(seen, seen._replace(turn_share=0.0)).turn_share == 0.0


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_information_is_reduced_about_the_turn_alone(share: float) -> None:
    factor = np.random.default_rng(3).normal(size=(3, 3))
    information, pivot = factor @ factor.T, np.array([0.3, -0.7])
    turn = np.array([*pivot, 1.0])
    reduced = without_turn(information, TurnEvidence(pivot, share))
    assert turn @ reduced @ turn == pytest.approx(share * (turn @ information @ turn), abs=1e-12)
    np.testing.assert_allclose(reduced[:2, :2], information[:2, :2])
