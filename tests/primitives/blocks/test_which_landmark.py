"""FIXATE among landmarks that look alike; `python -m benchmarks.blocks.which_landmark` tries many more."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.blocks.which_landmark import SHIPPED_PLAN, TRIED_PLANS, trial
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2

from .stacking import TASK, at_the_wall, scene_of


@pytest.mark.parametrize("off", [(0.032, 0.005, -0.051), (0.040, -0.048, -0.033)])
def test_a_neighbour_nearer_to_the_middle_of_the_picture_is_not_taken(
    off: tuple[float, float, float],
) -> None:
    """The base is so far off that the next block's landmark is at the expected position."""
    with at_the_wall(TASK / "servo_world.yaml", building=TASK / "servo_building.yaml", seed=4) as rig:
        scene = scene_of(rig)
        scene.move_base(rig.model.places["stacking"].pose.compose(Pose2(*off)))
        outcome = rig.do(Fixate(landmark="stacking"))
        assert isinstance(outcome, Success)
        fixed = rig.model.of(Blocks).fixed
        assert fixed is not None
        assert fixed.pose.distance(scene.base) < 0.0025


def test_a_row_is_looked_at_as_far_as_its_end(tmp_path: Path) -> None:
    assert trial(TRIED_PLANS["a row of 7, 75 mm apart"], "", 2, tmp_path) == "right"


def test_a_covered_landmark_is_not_its_neighbour(tmp_path: Path) -> None:
    reason = trial(SHIPPED_PLAN, "it is covered", 1, tmp_path)
    assert reason == "the landmark is not found where it should be by those around it"


def test_covered_landmark_of_a_row_is_not_mistaken(tmp_path: Path) -> None:
    """A scan at rest locates the moved base, so the row is not seen shifted by one."""
    reason = trial(TRIED_PLANS["a row of 4, 110 mm apart"], "it is covered", 2, tmp_path)
    assert reason == "the landmark is not found where it should be by those around it"
