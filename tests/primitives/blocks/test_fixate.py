"""Tests of FIXATE: the pose of the base by a landmark."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.fixate import Fixate, landmark_of
from handcart.primitives.blocks.fixating import covariance_of_mean, fixate, fixed_by, planned_view, sought
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.geometry.pose2 import Pose2

from .stacking import TASK, at_the_wall, scene_of


def moved_base(rig: Rig, x: float, y: float, turn: float) -> None:
    """Put the base elsewhere than it believes to be."""
    scene = scene_of(rig)
    scene.move_base(scene.base.compose(Pose2(x, y, turn)))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_travelling_error_is_measured(seed: int) -> None:
    with at_the_wall(seed=seed) as rig:
        outcome = rig.do(Fixate(landmark="stacking"))
        fixed, truth = rig.model.of(Blocks).fixed, scene_of(rig).base
    assert isinstance(outcome, Success)
    # The base also leans: that displaces what is at the table's height by up to a millimetre.
    assert fixed is not None
    assert fixed.pose.distance(truth) < 0.0025
    assert fixed.pose.turn(truth) < 0.001


def test_the_robot_then_knows_where_it_is() -> None:
    with at_the_wall(seed=3) as rig:
        before = rig.robot.pose.distance(scene_of(rig).base)
        rig.do(Fixate(landmark="stacking"))
        after = rig.robot.pose.distance(scene_of(rig).base)
    assert before > 0.01
    assert after < 0.0025


@pytest.mark.parametrize("turn", [0.006, -0.006])
def test_a_base_that_is_turned_once_it_was_found_is_a_fail(turn: float) -> None:
    """The wheels do not move, the gyros measure a turn: the measured pose is invalid."""
    with at_the_wall(seed=1) as rig:
        found: list[bool] = []
        robot: Any = rig.robot
        step = rig.robot.step

        def stepping(paused: bool = False) -> None:
            if rig.model.of(Blocks).fixed is not None and not found:
                found.append(True)
                moved_base(rig, 0.0, 0.0, turn)
            step(paused)

        robot.step = stepping
        outcome = rig.do(Fixate(landmark="stacking"))
        assert found
        assert isinstance(outcome, Fail), outcome
        assert rig.model.of(Blocks).fixed is None


@pytest.mark.parametrize(("x", "y"), [(0.11, 0.0), (-0.13, 0.06), (0.02, -0.12), (0.13, 0.09)])
def test_a_landmark_out_of_view_is_searched_for(x: float, y: float) -> None:
    with at_the_wall(seed=1) as rig:
        moved_base(rig, x, y, 0.05)
        outcome = rig.do(Fixate(landmark="stacking"))
        assert isinstance(outcome, Success)
        frames, fixed = outcome.evidence["frames"], rig.model.of(Blocks).fixed
        assert not isinstance(frames, str)
        assert frames > 5
        assert fixed is not None
        assert fixed.pose.distance(scene_of(rig).base) < 0.003


def test_an_arm_that_is_stopped_while_it_searches_is_a_fail() -> None:
    """It is not taken for a view out of reach, after which the next one is tried."""
    with at_the_wall(seed=1) as rig:
        moved_base(rig, 0.11, 0.0, 0.05)
        arm: Any = rig.robot.arm
        joints = arm.joints
        arm.joints = lambda: joints() + (0.3 if 2.2 < rig.robot.time < 2.3 else 0.0)
        outcome = rig.do(Fixate(landmark="stacking"))
    assert isinstance(outcome, Fail), outcome
    assert outcome.reason == "something stops the arm"


def world_without(path: Path, landmark: bool) -> Path:
    """The world without its landmark, or with something else in its place."""
    text = (TASK / "unload_world.yaml").read_text(encoding="utf-8")
    mark = "  - {x_m: 4.180, y_m: 1.800, height_m: 0.4}\n"
    assert mark in text
    other = "" if landmark else mark.replace("}", ", kind: square}")
    path.write_text(text.replace(mark, other), encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("landmark", [True, False], ids=["nothing there", "another mark there"])
def test_no_landmark_is_a_fail_and_the_arm_is_back(tmp_path: Path, landmark: bool) -> None:
    with at_the_wall(world_without(tmp_path / "world.yaml", landmark)) as rig:
        joints = scene_of(rig).joints.copy()
        outcome = rig.do(Fixate(landmark="stacking"))
        assert isinstance(outcome, Fail)
        assert "landmark is not found" in outcome.reason
        assert np.abs(scene_of(rig).joints - joints).max() < 0.005


def test_without_the_search_a_landmark_out_of_view_is_a_fail() -> None:
    with at_the_wall(seed=1) as rig:
        moved_base(rig, 0.11, 0.0, 0.05)
        assert isinstance(rig.do(Fixate(landmark="stacking", search=False)), Fail)


def test_a_landmark_that_the_plan_doesnt_have() -> None:
    with at_the_wall() as rig:
        outcome = rig.do(Fixate(landmark="stackin"))
    assert isinstance(outcome, Fail)
    assert outcome.permanent
    assert "did you mean 'stacking'?" in outcome.reason


@pytest.mark.parametrize("aside", [0.0, 0.055, -0.055])
def test_of_landmarks_beside_each_other_the_right_one_is_taken(aside: float) -> None:
    """They are 9 cm apart; where the hand is to look past the wanted one, another is nearer to its middle."""
    files = RigFiles(
        TASK / "servo_world.yaml",
        TASK / "map.yaml",
        TASK / "places.yaml",
        {"building": TASK / "servo_building.yaml"},
        "stacking",
    )
    with build_rig(files, robot="toyama/h1", seed=1) as rig:
        planned, found = looked_at(rig, 1, name="goal_3", aside=aside)
        assert planned.compose(found.planned_T_base).distance(scene_of(rig).base) < 0.004


def looked_at(
    rig: Rig,
    looks: int,
    at: Callable[[int], None] = lambda picture: None,
    name: str = "stacking",
    aside: float = 0.0,
) -> tuple[Pose2, Any]:
    """Return the result of a fixation outside of an attempt; `at` is called with each picture's number.

    `aside`: offset of the views from the landmark, in [m].
    """
    robot: Any = rig.robot
    model: Any = rig.model
    mark = landmark_of(model, name)
    planned = rig.model.places[mark.place].pose
    hand = planned_view(robot, mark, planned).base_T_hand.copy()
    hand[1, 3] += aside
    view = planned_view(robot, mark, planned, hand)
    building = rig.model.of(Blocks).building
    assert building is not None
    wanted = sought(name, building.landmarks, planned, robot.pose, robot.localization.covariance)
    looking = fixate(robot, view, wanted, "residual", Evidence(), looks=looks)
    take = robot.picture
    taken: list[None] = []

    def picture() -> Any:
        taken.append(None)
        at(len(taken))
        return take()

    robot.picture = picture
    while True:
        try:
            next(looking)
        except StopIteration as end:
            return planned, end.value
        robot.step()


def test_what_was_seen_before_the_base_was_moved_is_over() -> None:
    with at_the_wall(seed=1) as rig:

        def shifted(picture: int) -> None:
            if picture == 3:
                moved_base(rig, 0.006, -0.004, 0.0)

        planned, found = looked_at(rig, 3, shifted)
        assert len(found.seen) == 3
        assert found.frames > 4
        assert planned.compose(found.planned_T_base).distance(scene_of(rig).base) < 0.0025


def test_what_is_looked_at_more_often_is_surer() -> None:
    with at_the_wall(seed=1) as rig:
        planned, found = looked_at(rig, 4)
        assert rig.robot.spec.arm is not None
        accuracy_mm = rig.robot.spec.arm.accuracy_mm
        once = fixed_by(rig.robot, "stacking", "stacking", planned, found._replace(seen=found.seen[:1]))
        often = fixed_by(rig.robot, "stacking", "stacking", planned, found)
        assert len(found.seen) == 4
        assert once.sigma[0] == pytest.approx(accuracy_mm / 1e3)
        assert once.sigma[0] / 2 < often.sigma[0] < once.sigma[0]


def test_looks_that_differ_are_less_sure() -> None:
    """Sigma follows their scatter, and the arm's accuracy if a few agree by chance."""
    seen = [
        Pose2(0.01 + x, 0.0, turn)
        for x, turn in ((0.002, 0.0), (-0.002, 0.001), (0.002, 0.0), (-0.002, 0.001))
    ]
    found, noise = covariance_of_mean(seen, (3e-4, 4e-4)), (3e-4**2, 4e-4**2)
    assert found[0, 0] == pytest.approx((0.004**2 / 3 + noise[0]) / 4)
    assert found[1, 1] == pytest.approx(noise[0] / 4)
    assert found[2, 2] == pytest.approx((0.001**2 / 3 + noise[1]) / 4)
    assert covariance_of_mean(seen[:1] * 3, (3e-4, 4e-4))[0, 0] == pytest.approx(noise[0] / 3)
    assert covariance_of_mean(seen[:1], (3e-4, 4e-4))[2, 2] == pytest.approx(noise[1])


@pytest.mark.slow
def test_a_fixed_pose_is_as_far_off_as_its_sigma_says() -> None:
    """The base tilts under the arm: the localizer receives the pose without tilt."""
    squares = []
    for seed in range(4):
        with at_the_wall(seed=seed) as rig:
            rig.do(Fixate(landmark="stacking"))
            off = scene_of(rig).base.distance(rig.robot.pose)
            sigma = rig.robot.localization.sigma[0]
            assert 1e-4 < sigma < 1.5e-3
            squares.append((off / sigma) ** 2)
    assert np.mean(squares) < 4.0
    assert max(squares) < 16.0
