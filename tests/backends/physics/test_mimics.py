"""Joints that mimic others, nearer to the base than their leader or on another branch, in any engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.robots.mimic_robots import LEADER_COUNT, MimicRobot
from benchmarks.robots.mimics import MAX_LINK_ERROR, move
from handcart.backends.loading.robot_loading import load_robot

BACKENDS = ("kinematic", "mujoco", "pybullet")
SEEDS = (9, 10)


@pytest.mark.parametrize("name", BACKENDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_mimics_stand_where_the_tree_has_them_and_nothing_lags(name: str, seed: int) -> None:
    if name == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    moved = move(MimicRobot(seed), name, seed)
    assert moved.off < MAX_LINK_ERROR, moved.worst
    assert moved.lag < 5e-3


def test_some_follower_is_nearer_to_the_base_than_its_leader() -> None:
    """The seeds above show something: Pinocchio alone rejects one of these robots."""
    names = {seed: [joint.name for joint in MimicRobot(seed).joints] for seed in SEEDS}
    before = [
        joint
        for seed in SEEDS
        for joint in MimicRobot(seed).joints
        if joint.mimic is not None and names[seed].index(joint.name) < names[seed].index(joint.mimic.leader)
    ]
    assert before


def test_velocity_of_the_hand_counts_what_followers_move(tmp_path: Path) -> None:
    arm = load_robot(str(MimicRobot(9).write(tmp_path))).arm_model()
    q, step = np.full(LEADER_COUNT, 0.3), 1e-6
    for joint in range(LEADER_COUNT):
        ahead = q + step * np.eye(LEADER_COUNT)[joint]
        speed = (arm.forward(ahead)[:3, 3] - arm.forward(q)[:3, 3]) / step
        assert arm.jacobian(q)[:3, joint] == pytest.approx(speed, abs=1e-5)
