"""An arm on a lift, through CAN frames: a joint in mm that rests at its limit."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.can.can_arm import CanArm
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.bringup.axis_rungs import LimitsRung
from handcart.evaluation.bringup.operator import BenchOperator
from handcart.evaluation.bringup.site import Site
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from tests.lift_robot import write_lift_robot
from tests.take_book import write_take_book


@pytest.mark.parametrize(("read", "held"), [(-2e-4, 0.0), (0.1, 0.1), (0.2504, 0.25), (-0.04, -0.04)])
def test_a_joint_read_a_hair_beyond_its_limit_holds_the_limit(
    tmp_path: Path, read: float, held: float
) -> None:
    """Else no way can be planned from where it is; what is truly beyond isn't hidden."""
    robot = load_robot(str(write_lift_robot(tmp_path)))
    joints: list[Any] = [
        SimpleNamespace(position=at, limits=SimpleNamespace(speed=0.1)) for at in (read, *[0.5] * 6)
    ]
    arm = CanArm(robot.arm_model(), joints, np.ones(7), robot.period_s)
    arm.begin()
    assert arm.command()[0] == pytest.approx(held)


@pytest.mark.slow
def test_its_limits_are_tried_at_bring_up(tmp_path: Path) -> None:
    """The way to the lower limit is none, and its direction is known all the same."""
    name = str(write_lift_robot(tmp_path))
    task = LIBRARY_FOLDER / "task.yaml"
    site = Site(
        name, load_robot(name), BenchOperator(), tmp_path, task, "kinematic", LIBRARY_FOLDER / "world.yaml"
    )
    facts = LimitsRung().climb(site)["joint 1"]
    assert facts["lower_mm"] == pytest.approx(0.0, abs=0.5)
    assert facts["upper_mm"] == pytest.approx(250.0, abs=0.5)


@pytest.mark.slow
def test_it_takes_a_book(tmp_path: Path) -> None:
    task = write_take_book(tmp_path, str(write_lift_robot(tmp_path)))
    summary, status = run_task(task, tmp_path / "runs", RunOptions(backend="can", bench="kinematic"))
    assert (status, summary["outcome"], summary["situation"]) == (0, "Success", "in_hand")
    assert summary["metrics"].get("untrue", []) == []
