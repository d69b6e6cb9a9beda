"""Hypotheses about a pose over several scans: the right one is left, or all that look alike."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.locating.hypotheses import Hypotheses
from handcart.robotics.navigation.locating.local_map import LocalMap
from handcart.robotics.navigation.locating.next_view import (
    Surroundings,
    look_alike,
    next_view,
    predicted_difference,
)
from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField

from .test_global_search import REACH_M, ROOM, seen

SIZE = (9.0, 7.0)
PILLAR = (1.1, 1.1, 0.0, 0.7, 0.7)
SCREEN = (2.2, 2.2, math.pi / 4, 0.2, 1.6)  # hides the pillar
OTHER_SCREEN = (5.8, 3.8, math.pi / 4, 0.2, 1.6)  # where half a turn of the room puts it
TWINS = [*ROOM, SCREEN, OTHER_SCREEN, PILLAR]
HERE = Pose2(3.4, 3.4, 0.2)  # the pillar is hidden from there


def field_of(boxes: list[tuple[float, float, float, float, float]]) -> LikelihoodField:
    return LikelihoodField(from_boxes(boxes, 0.05, (-0.5, -0.5), SIZE))


@pytest.mark.slow
def test_a_hidden_pillar_decides_once_it_is_seen() -> None:
    """The robot is where the pillar is not; from its image, beams would pass through the pillar."""
    begun = Pose2(8.0 - HERE.x, 6.0 - HERE.y, HERE.theta - math.pi)
    hypotheses = Hypotheses(field_of(TWINS), 0.01)
    hypotheses.take(seen(TWINS, begun), Pose2(0.0, 0.0, 0.0))
    assert len(hypotheses.alive) == 2
    assert not hypotheses.is_unique
    there = Pose2(6.8, 3.5, 1.2)
    hypotheses.take(seen(TWINS, there), there.relative_to(begun))
    assert hypotheses.is_unique
    assert Pose2(*hypotheses.poses[0].tolist()).distance(there) < 0.03


def test_the_image_of_a_symmetric_room_is_never_refuted() -> None:
    hypotheses = Hypotheses(field_of(ROOM), 0.01)
    begun = Pose2(2.0, 2.0, 0.3)
    for pose in (begun, Pose2(5.0, 1.5, 1.0), Pose2(6.5, 4.5, -2.0), Pose2(2.0, 4.0, 0.0)):
        hypotheses.take(seen(ROOM, pose), pose.relative_to(begun))
        assert len(hypotheses.alive) == 2


@pytest.mark.slow
def test_the_same_view_again_is_no_further_evidence() -> None:
    """Unmapped things are seen again, too."""
    unmapped = [*TWINS, (4.5, 2.0, 0.0, 0.5, 0.5)]
    hypotheses = Hypotheses(field_of(TWINS), 0.01)
    for _ in range(3):
        hypotheses.take(seen(unmapped, HERE), Pose2(0.0, 0.0, 0.0))
    once = Hypotheses(field_of(TWINS), 0.01)
    once.take(seen(unmapped, HERE), Pose2(0.0, 0.0, 0.0))
    assert abs(hypotheses.margin - once.margin) < 3.0


def test_a_turn_counts_by_the_directions_that_it_newly_shows() -> None:
    """The lidar sees half a turn; a cupboard on one side tells the room from its image."""
    boxes = [*ROOM, (0.8, 3.0, 0.0, 1.0, 1.5)]
    hypotheses, begun = Hypotheses(field_of(boxes), 0.01), Pose2(4.5, 3.5, 0.5 * math.pi)
    weights = []
    for turn in (0.0, 0.25, 0.5 * math.pi, 0.5 * math.pi, math.pi):
        assert not hypotheses.is_unique
        pose = Pose2(begun.x, begun.y, begun.theta + turn)
        beams = seen(boxes, pose)
        ahead = np.abs(np.arctan2(np.sin(beams.angles), np.cos(beams.angles))) < 0.5 * math.pi
        half = beams._replace(angles=beams.angles[ahead], ranges=beams.ranges[ahead])
        hypotheses.take(half, pose.relative_to(begun))
        weights.append(hypotheses.looks[-1].weight)
    assert weights == pytest.approx([1.0, 0.25 / math.pi, 0.5 - 0.25 / math.pi, 0.0, 0.5], abs=0.03)
    assert hypotheses.is_unique
    assert Pose2(*hypotheses.poses[0].tolist()).distance(begun) < 0.05


@pytest.mark.slow
def test_a_robot_that_is_not_on_the_map_is_explained_nowhere() -> None:
    elsewhere = [(x, y, 0.4, 0.5, 0.5) for x in np.arange(0.0, 8.0, 1.7) for y in np.arange(0.0, 6.0, 1.9)]
    hypotheses = Hypotheses(field_of(TWINS), 0.01)
    hypotheses.take(seen(elsewhere, Pose2(4.3, 2.7, 0.0)), Pose2(0.0, 0.0, 0.0))
    assert not hypotheses.is_explained
    assert not hypotheses.is_unique


def test_the_next_view_is_where_the_hypotheses_differ() -> None:
    field, local = field_of(TWINS), LocalMap()
    local.add(HERE, seen(TWINS, HERE))
    poses = np.array([[*HERE], [8.0 - HERE.x, 6.0 - HERE.y, HERE.theta - math.pi]])
    around = Surroundings(local.grid, HERE, 0.3, np.array([[HERE.x, HERE.y]]))
    view = next_view(around, field, poses, REACH_M)
    assert view is not None
    assert view.difference > 0.0
    assert view.difference > predicted_difference(HERE, np.array([[HERE.x, HERE.y]]), field, poses, REACH_M)
    on_map = field.read(view.route)
    assert on_map.min() > 0.3  # it stays clear of everything


def test_only_a_map_with_an_exact_image_looks_alike() -> None:
    for boxes, alike in ((ROOM, True), (TWINS, False)):
        poses = np.array([[2.0, 4.5, 0.3], [6.0, 1.5, 0.3 - math.pi]])
        assert look_alike(field_of(boxes), poses, 0.3, 10.0, REACH_M) is alike


def test_a_local_map_shows_what_was_seen_and_nothing_else() -> None:
    local = LocalMap()
    assert local.is_due(HERE)
    local.add(HERE, seen(TWINS, HERE, reach=4.0))
    assert not local.is_due(HERE)
    grid = local.grid
    assert grid.inside(np.array([[HERE.x, HERE.y]]))[0]
    row, column = grid.to_cell(np.array([[HERE.x, HERE.y]]))[0]
    assert not grid.blocked[row, column]
    hidden = grid.to_cell(np.array([[PILLAR[0], PILLAR[1]]]))[0]
    assert grid.blocked[tuple(hidden)]
    assert np.abs(local.field.read(local.echoes)).max() < 0.06
