"""PICK_UP_BLOCK and STACK: from the robot's own table to the wall."""

from __future__ import annotations

import pytest

from primitives.fixate import Fixate
from primitives.outcome import Fail, GiveUp, Success
from primitives.pick_up_block import PickUpBlock
from primitives.stack import Stack
from robotics.geometry.transform import inverse

from .stacking import at_the_wall, do_with, scene_of, with_block


def error_mm(stage, number):
    """How far a block stands from its goal."""
    goal = stage.model.building.goals[number - 1].pose
    off = inverse(goal) @ scene_of(stage).blocks[str(number)].pose
    return 1e3 * float((off[0, 3] ** 2 + off[1, 3] ** 2) ** 0.5)


def test_a_block_is_taken_centred_between_the_fingers():
    with at_the_wall() as stage:
        stage.do(Fixate(landmark="stacking"))
        outcome = stage.do(PickUpBlock(number=2, at="robot"))
        assert isinstance(outcome, Success)
        assert scene_of(stage).held is scene_of(stage).blocks["2"]
        assert scene_of(stage).hand_T_held[1, 3] == pytest.approx(0.0, abs=1e-12)


def test_where_no_block_is_the_fingers_close_on_nothing():
    """S10: nothing tells where the block is."""
    with at_the_wall() as stage:
        stage.do(Fixate(landmark="stacking"))
        del scene_of(stage).blocks["3"]
        outcome = stage.do(PickUpBlock(number=3, at="robot"))
        assert isinstance(outcome, GiveUp)  # nothing tells where the block is
        assert "block 3 isn't seen" in outcome.reason
        assert "the fingers don't hold a block" in outcome.reason


@pytest.mark.parametrize("method", ["fix_once", "model", "imu", "fix_again", "fix_again_model"])
def test_each_method_puts_a_block_where_it_goes(method):
    with with_block(at_the_wall(seed=1)) as stage:
        outcome = stage.do(Stack(number=1, onto="goal", method=method))
        assert isinstance(outcome, Success), outcome
        assert error_mm(stage, 1) < 1.5
        assert scene_of(stage).held is None
        assert abs(outcome.evidence["seen_x_mm"]) < 2.0


def test_a_seat_on_the_robot_is_taken_too():
    with with_block(at_the_wall(seed=1)) as stage:
        assert isinstance(stage.do(Stack(number=1, onto="robot")), Success)
        assert scene_of(stage).blocks["1"].rest.value == "tray"


def test_without_a_landmark_seen_nothing_is_stacked():
    with at_the_wall() as stage:
        assert isinstance(stage.do(PickUpBlock(number=1, at="robot")), Success)
        outcome = stage.do(Stack(number=1, onto="goal", method="fix_once"))
        assert isinstance(outcome, Fail)
        assert "no landmark was seen" in outcome.reason
        assert scene_of(stage).held is scene_of(stage).blocks["1"]


def test_no_support_where_one_should_be_is_a_fail_with_the_block_in_hand():
    with with_block(at_the_wall()) as stage:
        goals = stage.model.building.goals
        raised = goals[0].model_copy(update={"height_m": 0.44})  # there is no row below
        stage.model.building = stage.model.building.model_copy(update={"goals": (raised, *goals[1:])})
        outcome = stage.do(Stack(number=1, onto="goal", method="fix_once"))
        assert isinstance(outcome, Fail)
        assert "doesn't touch down" in outcome.reason
        assert scene_of(stage).held is scene_of(stage).blocks["1"]


def test_something_in_the_goals_place_is_a_fail_with_the_block_in_hand():
    with with_block(at_the_wall()) as stage:
        scene = scene_of(stage)
        other = scene.blocks["5"]
        other.rest, other.pose = type(other.rest).TABLE, stage.model.building.goals[0].pose
        scene.changes += 1
        outcome = stage.do(Stack(number=1, onto="goal", method="fix_once"))
        assert isinstance(outcome, Fail)
        assert "something stands where the block goes" in outcome.reason
        assert scene.held is scene.blocks["1"]


def test_a_block_that_is_taken_away_once_placed_is_no_success():
    def vanish(scene):
        del scene.blocks["1"]
        scene.changes += 1

    with with_block(at_the_wall()) as stage:
        outcome = do_with(
            stage,
            Stack(number=1, onto="goal", method="fix_once"),
            lambda scene: scene.blocks["1"].rest.value == "table",
            vanish,
        )
    assert isinstance(outcome, GiveUp)
    assert "isn't seen where it was put" in outcome.reason


def test_a_block_pushed_aside_once_placed_is_seen():
    def push(scene):
        scene.blocks["1"].pose[1, 3] += 0.011
        scene.changes += 1

    with with_block(at_the_wall()) as stage:
        outcome = do_with(
            stage,
            Stack(number=1, onto="goal", method="fix_once"),
            lambda scene: scene.blocks["1"].rest.value == "table",
            push,
        )
    assert not isinstance(outcome, Success)
    assert "beside its goal" in outcome.reason
