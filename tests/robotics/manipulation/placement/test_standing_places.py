"""Free places of a base, and the part of the seam that could be tracked instead."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.arms.score_rule import Measure, ScoreRule
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.nearest_reachable import with_nearest
from handcart.robotics.manipulation.placement.placement_division import best_division
from handcart.robotics.manipulation.placement.standing_places import OpenFloor, stands_clear
from handcart.robotics.navigation.maps.grid_map import from_boxes

from ..seams import arched, stands

BASES = stands((-1.8, 1.8, 19), (-1.8, 1.8, 19), 2)


def test_no_way_leads_behind_a_wall_or_into_it() -> None:
    wall = [(0.0, 0.0, 0.0, 4.0, 0.1)]
    grid = from_boxes(wall, 0.05, (-2.0, -2.0), (4.0, 4.0))
    floor = OpenFloor(grid, 0.3)
    found = floor.leads_to(BASES, floor.reached_from((0.0, -1.0)))
    y = BASES[:, 1]
    assert not found[y > -0.3].any()
    assert found[(y < -0.45) & (y > -1.6) & (np.abs(BASES[:, 0]) < 1.6)].all()
    assert not floor.reached_from((0.0, 0.0)).any()
    assert not floor.reached_from((9.0, 0.0)).any()


def test_a_base_stands_below_what_hangs_and_beside_what_stands() -> None:
    body = Box(transform((0.1, 0.0, 0.3)), (0.8, 0.4, 0.6))
    beam = Box(transform((0.0, 0.0, 0.9)), (4.0, 0.3, 0.4))
    assert stands_clear(BASES, [body], [beam]).all()
    assert not stands_clear(BASES, [body], [beam], margin=0.15).all()
    post = Box(transform((0.0, 0.0, 0.5)), (0.2, 0.2, 1.0))
    clear = stands_clear(BASES, [body], [post])
    near = np.hypot(BASES[:, 0], BASES[:, 1])
    assert not clear[near < 0.25].any()
    assert clear[near > 0.8].all()


def _scores(bases: np.ndarray, path: ToolPath) -> PlacementScores:
    return PitchArm().scores(bases, path, ScoreRule.uniform(Measure.SURE, 0.2, 1.0, 4))


def test_the_nearest_reachable_position_is_proposed() -> None:
    path, bases = arched(60, rise=1.3), stands((-2.5, 2.5, 26), (-1.6, -0.3, 14))
    with pytest.raises(Untrackable, match="can't be tracked from any") as caught:
        best_division(_scores(bases, path), path.lengths, 3)
    better = with_nearest(caught.value, _scores, path, bases)
    assert better.index == caught.value.index
    assert better.nearest is not None
    gap = np.linalg.norm(better.nearest - path.points[better.index])
    assert 0.0 < gap < 0.3
    assert "nearest that can be reached" in str(better)
    moved = path._replace(points=path.points + better.nearest - path.points[better.index])
    assert _scores(bases, moved).usable[:, better.index].any()
