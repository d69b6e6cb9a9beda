"""Tests of the preconditions of primitives: a reason is returned before anything moves."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.pick_up_block import PickUpBlock
from handcart.primitives.blocks.stack import Stack
from handcart.primitives.books.books import Books
from handcart.primitives.books.insert import Insert
from handcart.primitives.books.pick_up import PickUp
from handcart.primitives.books.recognize import Recognize
from handcart.primitives.books.release import Release
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.driving.orient import Orient
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.grip import close
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.primitives.preconditions.hand_use import USE_UNDECLARED, USES_NO_FINGERS
from handcart.robotics.geometry.transform import transform
from tests.primitives.blocks.stacking import at_the_wall, scene_of, with_block
from tests.primitives.conftest import Rig as BookRig


class _Still(ActionPrimitive):
    """Does nothing."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        return
        yield


def commanded(rig: Rig | BookRig, primitive: ActionPrimitive) -> tuple[str, float]:
    """The reason of a Fail, and how far arm and fingers were commanded meanwhile."""
    robot, moves = rig.robot, [0.0]
    arm, width = robot.arm.command().copy(), robot.gripper.command()
    step = robot.step

    def stepping(paused: bool = False) -> None:
        moves.append(float(np.abs(robot.arm.command() - arm).max()) + abs(robot.gripper.command() - width))
        step(paused)

    robot.step = stepping  # type: ignore[method-assign]
    outcome = rig.do(primitive) if isinstance(rig, Rig) else rig.run(primitive)
    robot.step = step  # type: ignore[method-assign]
    assert isinstance(outcome, Fail)
    return outcome.reason, max(moves)


def test_pick_up_block_with_another_in_the_hand_moves_nothing() -> None:
    with with_block(at_the_wall()) as rig:
        assert rig.model.in_hand == "block 1"
        found = commanded(rig, PickUpBlock(number=2, at="robot"))
        assert found == ("the hand is not empty: it holds block 1", 0.0)
        assert scene_of(rig).held.name == "block 1"


def test_stack_of_another_block_than_the_held_one_is_refused() -> None:
    with with_block(at_the_wall()) as rig:
        assert commanded(rig, Stack(number=2, onto="robot")) == ("the hand holds block 1, not block 2", 0.0)
        assert isinstance(rig.do(Stack(number=1, onto="robot")), Success)
        assert rig.model.in_hand == ""
        assert commanded(rig, Stack(number=1, onto="goal"))[0] == "the hand is empty; it must hold block 1"


def test_pick_up_block_where_none_is_fails_restored() -> None:
    with at_the_wall() as rig:
        with_block(rig)
        scene = scene_of(rig)
        rig.do(Stack(number=1, onto="goal"))
        rig.model.of(Blocks).placed = ()
        outcome = rig.do(PickUpBlock(number=1, at="robot"))
        assert isinstance(outcome, Fail)
        assert outcome.reason == "the fingers closed on nothing where block 1 should be"
        assert scene.held is None


@pytest.mark.parametrize("primitive", [PickUp(), Recognize()])
def test_book_primitives_that_need_an_empty_hand_say_what_it_holds(
    at_slot: Callable[..., BookRig], primitive: ActionPrimitive
) -> None:
    rig = at_slot()
    rig.model.in_hand = "book 117"
    assert commanded(rig, primitive) == ("the hand is not empty: it holds book 117", 0.0)


@pytest.mark.parametrize("primitive", [Insert(shelf="shelf_1"), Release(shelf="shelf_1")])
def test_book_primitives_with_another_book_held_say_which(
    at_slot: Callable[..., BookRig], primitive: ActionPrimitive
) -> None:
    rig = at_slot()
    rig.model.in_hand = "book 3"
    assert commanded(rig, primitive) == ("the hand holds book 3, not book 117", 0.0)
    rig.model.of(Books).book = None
    assert commanded(rig, primitive) == ("no book has been recognized", 0.0)


@pytest.mark.parametrize("primitive", [MoveTo(place="shelf_1"), Orient()])
def test_driving_with_the_arm_out_is_refused(
    make_rig: Callable[..., BookRig], monkeypatch: pytest.MonkeyPatch, primitive: ActionPrimitive
) -> None:
    rig = make_rig()
    monkeypatch.setattr(rig.robot, "base_T", lambda _: transform((0.6, 0.1, 0.7)))
    reason, moved = commanded(rig, primitive)
    assert "the hand stands out beyond the robot's footprint, 0.61 m" in reason
    assert moved == 0.0


def test_fingers_closed_on_each_other_are_an_empty_hand() -> None:
    with at_the_wall() as rig:
        for _ in close(rig.robot):
            rig.robot.step()
        assert rig.robot.gripper.closed_on_something()
        assert isinstance(with_block(rig), type(rig))


def test_undeclared_primitives_leave_the_hand_unless_they_need_it() -> None:
    class Waves(_Still):
        needs: ClassVar = (Arm,)

    class Grabs(_Still):
        needs: ClassVar = (Arm, Gripper)

    assert (Waves.usual_hand_use(), Grabs.usual_hand_use()) == (USES_NO_FINGERS, USE_UNDECLARED)
