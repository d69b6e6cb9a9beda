"""Drives in MuJoCo follow set-points that move, in each step of the solver."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.mujoco.mujoco_backend import MujocoBackend
from handcart.backends.physics.body.joint_group import MIN_TORQUE_RATIO
from handcart.backends.physics.body.physics_arm import CATCHES_UP
from handcart.backends.simulation.world_files.world_model import world_model

WORLD = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}}


@pytest.fixture
def backend() -> Iterator[Any]:
    made = MujocoBackend(load_robot("librarian"), world_model().model_validate(WORLD), 0)
    yield made
    made.close()


def test_an_arm_is_where_it_is_commanded_to_be_while_it_moves(backend: Any) -> None:
    arm, off = backend._arm, []
    ways = 0.01 * np.array([1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    for number in range(40):
        arm.move(arm.command() + ways * min(1.0, number / 10, (39 - number) / 10))
        backend.step()
        off.append(np.abs(arm.command() + arm._offset - arm.true_joints()).max())
    assert max(off) < 3e-3
    for _ in range(10):
        backend.step()
    assert np.abs(arm.command() + arm._offset - arm.true_joints()).max() < 2e-5


def test_a_joint_that_was_held_back_comes_back_no_faster_than_it_may(backend: Any) -> None:
    arm, engine = backend._arm, backend._engine
    drives, effort, fastest = arm._drives, arm._effort, arm._fastest
    goal, nowhere = arm.true_joints(), np.zeros(len(arm._effort))
    backend._body.reset("joint_1", goal[0] - 0.5)
    engine.substeps, speeds = 1, []
    for step in range(400):
        if step % 20 == 0:
            drives.give(goal - drives.states()[0], nowhere, effort, fastest, CATCHES_UP)
            drives.push(arm._model.gravity_torque(goal))
        engine.step()
        speeds.append(drives.states()[1][0])
    assert max(speeds) < 1.05 * fastest[0]
    assert abs(drives.states()[0][0] - goal[0]) < 1e-3


@pytest.mark.parametrize(("off", "share"), [(0.0, 0.0), (0.015, 0.5 + MIN_TORQUE_RATIO), (0.5, 1.0)])
def test_what_is_in_the_way_of_a_joint_feels_a_spring(backend: Any, off: float, share: float) -> None:
    arm, engine = backend._arm, backend._engine
    goal, nowhere = arm.true_joints(), np.zeros(len(arm._effort))
    goal[0] += off
    engine.substeps = 1
    arm._drives.give(goal - arm._drives.states()[0], nowhere, arm._effort, arm._fastest, CATCHES_UP)
    engine.data.qvel[:] = 0.0
    engine.step()
    speed = int(engine.model.joint("robot/joint_1").dofadr[0])
    assert engine.data.qfrc_actuator[speed] == pytest.approx(
        share * arm._effort[0], abs=0.02 * arm._effort[0]
    )
