"""An arm that strikes a hanging thing while the base drives: noticed, left the way it came, remembered."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
import pytest

from benchmarks.driving.unseen_boxes import try_world
from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.bumps import avoided_points, keep_off_bumps
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.outcome import Fail
from tests.primitives.conftest import Rig

BOX = (0.62, 1.43)
HANGING = f"  - {{name: box, x_m: {BOX[0]}, y_m: {BOX[1]}, size_m: [0.1, 0.1, 0.6], above_m: 0.7}}\n"


class Curve(ActionPrimitive):
    """Drive a curve to the left; the elbow is on the left, behind the middle of the base."""

    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for number in range(60):
            speed = min(0.5, 0.025 * (number + 1))
            robot.base.drive(speed, speed)
            yield


def test_an_elbow_that_strikes_a_box_leaves_it_once(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(furniture=HANGING)
    failed = rig.run(Curve())
    assert isinstance(failed, Fail)
    assert "ran into something" in failed.reason
    assert [contact.other for contact in rig.scene.contacts] == ["box"]
    assert rig.scene.contacts[0].body.startswith("link_")


def test_what_an_elbow_struck_is_planned_around(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(furniture=HANGING)
    rig.run(Curve())
    assert (np.hypot(*(rig.model.arm_bumps[:, :2] - BOX).T) < 0.12).any()
    assert (np.hypot(*(avoided_points(rig.robot, rig.model) - BOX).T) < 0.05).any()


def test_a_new_action_keeps_off_more_than_one_that_returns(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    rig.model.bumps = np.array([[3.0, 1.0, 0.0]])
    rig.model.arm_bumps = np.array([[2.8, 1.2, 0.0]])
    keep_off_bumps(rig.robot, rig.model, returns=True)
    directions = np.abs(np.arctan2(rig.robot.base.felt[:, 1] - 1.0, rig.robot.base.felt[:, 0] - 3.0))
    assert np.degrees(directions.max()) < 46.0
    keep_off_bumps(rig.robot, rig.model)
    felt = rig.robot.base.felt
    assert np.degrees(np.abs(np.arctan2(felt[:, 1] - 1.0, felt[:, 0] - 3.0))).max() > 74.0
    assert (np.hypot(*(felt - (2.8, 1.2)).T) < 1e-9).any()


def test_the_way_back_has_the_headings_of_the_way_in(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(furniture=HANGING)
    poses, step = [], rig.robot.step

    def and_look(paused: bool = False) -> None:
        step(paused)
        poses.append((*rig.scene.base, bool(rig.scene.contacts)))

    rig.robot.step = and_look  # type: ignore[method-assign]
    rig.run(Curve())
    table = np.array(poses)
    came, back = table[table[:, 3] == 0.0], table[table[:, 3] == 1.0]
    close = back[np.hypot(*(back[:, :2] - back[0, :2]).T) < 0.3]
    assert np.hypot(*(back[:, :2] - back[0, :2]).T).max() > 0.3
    for x, y, theta, _ in close:
        nearest = came[np.argmin(np.hypot(*(came[:, :2] - (x, y)).T))]
        assert abs(np.degrees(theta - nearest[2])) < 2.5


@pytest.mark.slow
def test_a_box_that_the_arm_struck_in_a_drive_is_not_touched_again() -> None:
    """World 90 of the benchmark: the elbow passes a hanging box and turns into it."""
    result = try_world(90, "kinematic")
    assert max(result.touched.values(), default=0) <= 1
    assert result.pushed <= 1.0
