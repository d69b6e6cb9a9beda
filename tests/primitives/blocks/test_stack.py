"""PICK_UP_BLOCK and STACK: from the robot's own table to the wall."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.capabilities.imu import Imu
from handcart.backends.simulation.blocks.block_props import BlockProps
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.blocks.base_correction import ByModel
from handcart.primitives.blocks.base_turn import turn_by_gyros
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.building import Building
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.blocks.pick_up_block import PickUpBlock
from handcart.primitives.blocks.stack import Stack
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.transform import inverse, transform
from tests.primitives.changed_scene import do_when, scene_of

from .stacking import at_the_wall, with_block

ROBOT = Path(__file__).parents[3] / "backends" / "robots" / "toyama"


def building_of(rig: Rig) -> Building:
    building = rig.model.of(Blocks).building
    assert building is not None
    return building


def error_mm(rig: Rig, number: int) -> Any:
    """Return the distance of a block from its goal, in [mm]."""
    goal = building_of(rig).goals[number - 1].pose
    off = inverse(goal) @ scene_of(rig).of(BlockProps).blocks[str(number)].pose
    return 1e3 * float((off[0, 3] ** 2 + off[1, 3] ** 2) ** 0.5)


def test_a_block_is_taken_centred_between_the_fingers() -> None:
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        outcome = rig.do(PickUpBlock(number=2, at="robot"))
        assert isinstance(outcome, Success)
        assert scene_of(rig).held is scene_of(rig).of(BlockProps).blocks["2"]
        assert scene_of(rig).hand_T_held[1, 3] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("look", [False, True])
def test_looking_first_the_block_is_taken_at_its_middle(look: bool) -> None:
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        scene = scene_of(rig)
        scene.of(BlockProps).blocks["2"].base_T_thing[1, 3] += 0.003
        scene.changes += 1
        assert isinstance(rig.do(PickUpBlock(number=2, at="robot", look=look)), Success)
        along_the_fingers = abs(scene.hand_T_held[2, 3])
        assert (along_the_fingers < 0.001) == look


def test_looking_first_a_missing_block_is_a_fail_with_the_arm_back() -> None:
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        del scene_of(rig).of(BlockProps).blocks["3"]
        before = rig.robot.arm.joints()
        outcome = rig.do(PickUpBlock(number=3, at="robot", look=True))
        assert isinstance(outcome, Fail)
        assert "block 3 isn't seen at its planned place" in outcome.reason
        assert rig.robot.arm.joints() == pytest.approx(before, abs=1e-3)


def test_block_picked_with_stow_is_carried_inside_the_footprint() -> None:
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        assert isinstance(rig.do(PickUpBlock(number=2, at="robot", stow=True)), Success)
        assert rig.robot.arm.joints() == pytest.approx(rig.robot.spec.posture("home"), abs=5e-3)
        assert isinstance(rig.do(MoveTo(place="stacking")), Success)
        assert scene_of(rig).held is scene_of(rig).of(BlockProps).blocks["2"]


def test_the_gyros_tell_how_far_the_base_turned() -> None:
    """The model's prediction of a swing has an error; the gyros measure the turn itself."""
    with with_block(at_the_wall(seed=3)) as rig:
        before, stood = rig.model.of(Blocks).fixed, scene_of(rig).base.theta
        assert isinstance(rig.do(Stack(number=1, onto="goal", method="fix_once")), Success)
        turned = scene_of(rig).base.theta - stood
        assert before is not None
        felt = turn_by_gyros(rig.robot, before)
        assert abs(turned) > 2e-4
        assert felt.yaw == pytest.approx(turned, abs=3 * felt.sigma)
        assert felt.sigma < 3e-4


def test_where_no_block_is_the_fingers_close_on_nothing() -> None:
    """S10: nothing was there."""
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        del scene_of(rig).of(BlockProps).blocks["3"]
        outcome = rig.do(PickUpBlock(number=3, at="robot"))
        assert isinstance(outcome, Fail)  # they met nothing, so nothing was moved
        assert outcome.reason == "the fingers closed on nothing where block 3 should be"


def test_a_width_that_is_not_read_is_no_proof_that_nothing_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    """The block is between the fingers: after the restoring it is looked at."""
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        gripper = rig.robot.gripper
        honest, closes = gripper.width, gripper.closed_on_something
        monkeypatch.setattr(gripper, "width", lambda: math.nan if closes() else honest())
        primitive = PickUpBlock(number=2, at="robot")
        outcome = rig.do(primitive)
        assert not isinstance(outcome, Success)
        assert primitive._touched
        assert "closed on nothing" not in outcome.reason


@pytest.mark.parametrize(
    "method", ["fix_once", "model", "imu", "fix_again", "fix_again_model", "fix_again_imu"]
)
def test_each_method_puts_a_block_where_it_goes(method: Any) -> None:
    with with_block(at_the_wall(seed=1)) as rig:
        outcome = rig.do(Stack(number=1, onto="goal", method=method))
        assert isinstance(outcome, Success), outcome
        assert error_mm(rig, 1) < 1.5
        assert scene_of(rig).held is None
        seen_x_mm = outcome.evidence["seen_x_mm"]
        assert not isinstance(seen_x_mm, str)
        assert abs(seen_x_mm) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("askew", [0.0, 0.02])
@pytest.mark.parametrize("seed", [1, 3])
def test_a_lean_that_the_model_has_wrong_is_felt(seed: int, askew: float, tmp_path: Path) -> None:
    """Three times as much as it leans. Neither need the sensors be mounted level, nor the floor be."""
    shutil.copytree(ROBOT, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "h1.yaml"
    known = file.read_text(encoding="utf-8")
    wrong = known.replace("roll_mrad_per_m: -8.494", "roll_mrad_per_m: -25").replace("7.012", "21")
    file.write_text(wrong, encoding="utf-8")
    errors = {}
    for method in ("fix_again_model", "fix_again_imu"):
        with at_the_wall(robot=str(file), seed=seed) as rig:
            imu: Any = rig.robot.backend.get(Imu)
            feels, mount = imu.accelerations, transform(rpy=(askew, -askew, 0.0))[:3, :3]
            imu.accelerations = lambda feels=feels, mount=mount: mount.T @ feels()
            with_block(rig, 5)
            outcome = rig.do(Stack(number=5, onto="goal", method=method))
            assert isinstance(outcome, Success), outcome
            errors[method] = error_mm(rig, 5)
    assert errors["fix_again_imu"] < 0.6 < 0.9 < errors["fix_again_model"]


def test_a_seat_on_the_robot_is_taken_too() -> None:
    with with_block(at_the_wall(seed=1)) as rig:
        assert isinstance(rig.do(Stack(number=1, onto="robot")), Success)
        assert scene_of(rig).of(BlockProps).blocks["1"].rest.value == "tray"


def test_without_a_landmark_seen_nothing_is_stacked() -> None:
    with at_the_wall() as rig:
        assert isinstance(rig.do(PickUpBlock(number=1, at="robot")), Success)
        outcome = rig.do(Stack(number=1, onto="goal", method="fix_once"))
        assert isinstance(outcome, Fail)
        assert "no landmark was seen" in outcome.reason
        assert scene_of(rig).held is scene_of(rig).of(BlockProps).blocks["1"]


@pytest.mark.parametrize("method", ["imu", "fix_again_imu"])
def test_without_inertial_sensors_their_methods_are_refused(method: Any) -> None:
    with with_block(at_the_wall()) as rig:
        rig.robot.spec = rig.robot.spec.model_copy(update={"imu": None})
        outcome = rig.do(Stack(number=1, onto="goal", method=method))
        assert isinstance(outcome, Fail)
        assert f"the method {method} needs inertial sensors" in outcome.reason
        assert scene_of(rig).held is scene_of(rig).of(BlockProps).blocks["1"]


def test_missing_support_is_a_fail_with_the_block_in_hand() -> None:
    with with_block(at_the_wall()) as rig:
        goals = building_of(rig).goals
        raised = goals[0].model_copy(update={"height_m": 0.44})  # it has no row below
        rig.model.of(Blocks).building = building_of(rig).model_copy(update={"goals": (raised, *goals[1:])})
        outcome = rig.do(Stack(number=1, onto="goal", method="fix_once"))
        assert isinstance(outcome, Fail)
        assert "doesn't touch down" in outcome.reason
        assert scene_of(rig).held is scene_of(rig).of(BlockProps).blocks["1"]


def test_occupied_goal_is_a_fail_with_the_block_in_hand() -> None:
    with with_block(at_the_wall()) as rig:
        scene = scene_of(rig)
        other = scene.of(BlockProps).blocks["5"]
        other.rest, other.pose = type(other.rest).TABLE, building_of(rig).goals[0].pose
        scene.changes += 1
        outcome = rig.do(Stack(number=1, onto="goal", method="fix_once"))
        assert isinstance(outcome, Fail)
        assert "an obstacle is at the block's goal" in outcome.reason
        assert scene.held is scene.of(BlockProps).blocks["1"]


def test_a_block_that_is_taken_away_once_placed_is_no_success() -> None:
    def vanish(scene: Any) -> None:
        del scene.of(BlockProps).blocks["1"]
        scene.changes += 1

    with with_block(at_the_wall()) as rig:
        outcome = do_when(
            rig,
            Stack(number=1, onto="goal", method="fix_once"),
            lambda scene: scene.of(BlockProps).blocks["1"].rest.value == "table",
            vanish,
        )
    assert isinstance(outcome, GiveUp)
    assert "isn't seen where it was put" in outcome.reason


@pytest.mark.parametrize(
    ("aside", "turned", "words"),
    [(0.011, 0.0, "next to its goal"), (0.0, math.radians(5.0), "turned against its goal")],
)
def test_a_block_moved_once_placed_is_seen(aside: float, turned: float, words: str) -> None:
    def push(scene: Any) -> None:
        block = scene.of(BlockProps).blocks["1"]
        block.pose = block.pose @ transform((0.0, 0.0, 0.0), rpy=(0.0, 0.0, turned))
        block.pose[1, 3] += aside
        scene.changes += 1

    with with_block(at_the_wall()) as rig:
        outcome = do_when(
            rig,
            Stack(number=1, onto="goal", method="fix_once"),
            lambda scene: scene.of(BlockProps).blocks["1"].rest.value == "table",
            push,
        )
    assert not isinstance(outcome, Success)
    assert words in outcome.reason


def stop_arm(rig: Rig) -> None:
    """Let something stop the arm for half a second."""
    arm: Any = rig.robot.arm
    joints, until = arm.joints, rig.robot.time + 0.5
    arm.joints = lambda: joints() + (0.3 if rig.robot.time < until else 0.0)


def test_block_taken_back_from_its_goal_is_not_known_there() -> None:
    """The arm is stopped on its way home, when the block was already seen at its goal."""
    with with_block(at_the_wall()) as rig:
        blocks, stack = rig.model.of(Blocks), Stack(number=1, onto="goal", method="fix_once", stow=True)
        outcome = do_when(rig, stack, lambda _: bool(blocks.placed), lambda _: stop_arm(rig))
        assert isinstance(outcome, Fail), outcome
        assert scene_of(rig).held is scene_of(rig).of(BlockProps).blocks["1"]
        assert blocks.placed == ()


def test_block_put_back_on_the_robot_is_not_back_at_the_supply() -> None:
    with at_the_wall() as rig:
        rig.do(Fixate(landmark="stacking"))
        rig.model.of(Blocks).taken = (1, 2)
        pick = PickUpBlock(number=2, at="robot", stow=True)
        outcome = do_when(rig, pick, lambda scene: scene.held is not None, lambda _: stop_arm(rig))
        assert isinstance(outcome, Fail), outcome
        assert rig.model.of(Blocks).taken == (1, 2)


@pytest.mark.parametrize("primitive", [PickUpBlock(number=1, at="robot"), Stack(number=1, onto="robot")])
def test_without_seats_on_the_robot_no_block_is_sought_there(primitive: ActionPrimitive) -> None:
    with with_block(at_the_wall()) if isinstance(primitive, Stack) else at_the_wall() as rig:
        rig.model.of(Blocks).building = building_of(rig).model_copy(update={"carried": ()})
        outcome = rig.do(primitive)
    assert isinstance(outcome, Fail), outcome
    assert "the plan has no seats on the robot's own table" in outcome.reason
    assert outcome.permanent


def test_block_put_back_at_another_place_is_a_give_up() -> None:
    """The picture decides, not the force on the hand."""
    with at_the_wall() as rig:
        assert isinstance(rig.do(Fixate(landmark="stacking")), Success)
        scene, gripper, outcome = scene_of(rig), rig.robot.gripper, None
        periods = attempt(PickUpBlock(number=1, at="robot"), rig.robot, rig.model)
        cancelled = pushed = False
        while outcome is None:
            try:
                if scene.held is not None and scene.held.pose[2, 3] > 0.48 and not cancelled:
                    cancelled = True
                    periods.throw(Discrepancy("cancelled by the operator"))
                else:
                    next(periods)
            except StopIteration as end:
                outcome = end.value
            if cancelled and scene.held is None and gripper.width() > 0.04 and not pushed:
                pushed = True
                scene.of(BlockProps).blocks["1"].base_T_thing[1, 3] += 0.012
                scene.move_base(scene.base)
            rig.robot.step()
    assert isinstance(outcome, GiveUp), outcome
    assert "block 1 isn't at its place" in outcome.reason


def test_the_base_is_still_to_turn_when_the_block_is_yet_to_swing() -> None:
    """The suspension's model predicts the same turn for each past and each coming swing."""
    with with_block(at_the_wall()) as rig:
        fixed, correction = rig.model.of(Blocks).fixed, ByModel()
        assert fixed is not None
        swing = rig.robot.spec.suspension.model.yaw_per_swing
        turned = [correction.turned(rig.robot, fixed._replace(swings=3), more) for more in (0, 1, 2)]
        assert turned == pytest.approx([3 * swing, 4 * swing, 5 * swing])
        assert swing != 0.0
