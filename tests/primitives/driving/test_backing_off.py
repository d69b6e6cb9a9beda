"""Backing off from what holds the base, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.driving.cluttered_robot import write_robot
from handcart.primitives.driving.backing_off import BACK_OFF_M, BACK_OFF_MAX_TRIES, BackingOff, PinnedWatch
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.way_guard import HoldingObstacle
from tests.primitives.conftest import Rig


@pytest.mark.parametrize("reverse", [False, True])
def test_backing_off_drives_against_the_last_direction(make_rig: Callable[..., Rig], reverse: bool) -> None:
    rig = make_rig()
    before = rig.scene.base
    for _ in BackingOff().drive(rig.robot, reverse):
        rig.robot.step()
    moved = before.inverse().compose(rig.scene.base)
    assert math.copysign(1.0, moved.x) == (1.0 if reverse else -1.0)
    assert 0.8 * BACK_OFF_M < abs(moved.x) < 1.2 * BACK_OFF_M


@pytest.mark.parametrize("reverse", [False, True])
def test_backing_off_starts_and_ends_within_the_acceleration(
    make_rig: Callable[..., Rig], reverse: bool
) -> None:
    robot, speeds = make_rig().robot, [0.0]
    for _ in BackingOff().drive(robot, reverse):
        robot.step()
        speeds.append(robot.command.along)
    most = robot.drive_limits.acceleration * robot.period
    assert max(abs(now - last) for last, now in pairwise(speeds)) < most + 1e-9
    assert abs(speeds[-1]) < 1e-3
    assert max(map(abs, speeds)) > 0.1


def test_backing_off_towards_a_near_wall_ends_before_it(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(start_y=0.5)
    for periods, _ in enumerate(BackingOff().drive(rig.robot, False)):
        rig.robot.step()
        assert periods < 100
    assert rig.scene.contacts == []
    assert max(map(abs, rig.robot.command)) < 1e-3


def test_backing_off_ends_after_its_tries_until_they_are_reset(make_rig: Callable[..., Rig]) -> None:
    backing_off, robot = BackingOff(), make_rig().robot
    for _ in range(BACK_OFF_MAX_TRIES):
        assert backing_off.may_try
        next(backing_off.drive(robot, False))
    assert not backing_off.may_try
    backing_off.tries = 0
    assert backing_off.may_try


def test_backing_off_of_a_base_that_still_rolls_ahead_leaves(make_rig: Callable[..., Rig]) -> None:
    """The guard holds the base in its old direction; that doesn't end the drive in the other one."""
    rig = make_rig()
    robot = rig.robot
    while robot.held is None:
        robot.base.drive(0.3, 0.0)
        robot.step()
    robot.command = robot.command._replace(speed=0.1)
    before = rig.scene.base
    for periods, _ in enumerate(BackingOff().drive(robot, False)):
        robot.step()
        assert periods < 200
    assert before.inverse().compose(rig.scene.base).x < -0.8 * BACK_OFF_M


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_held_base_that_turns_to_and_fro_stays_off_and_is_pinned(
    make_rig: Callable[..., Rig], tmp_path: Path, seed: int
) -> None:
    """It doesn't creep nearer with each range that the noise makes longer."""
    post = "  - {name: post, x_m: 1.0, y_m: 1.6, size_m: [0.1, 0.1, 1.0]}\n"
    rig = make_rig(furniture=post, robot=str(write_robot(tmp_path, (0.22,), 2.0, "scan")), seed=seed)
    robot = rig.robot
    watch = PinnedWatch(robot.pose)
    while robot.time < 25.0:
        robot.base.drive(0.14, 1.2 * math.sin(4.0 * robot.time))
        robot.step()
        watch.note(robot, False)
    assert rig.scene.contacts == []
    assert watch.is_pinned


def test_held_base_that_turns_on_is_not_pinned() -> None:
    held = HoldingObstacle("scan", 0.3, 0.0, 0.3, 0.35)
    disc = SimpleNamespace(footprint_shape=SimpleNamespace(is_disc=True))
    robot: Any = SimpleNamespace(pose=Pose2(0.0, 0.0, 3.0), held=held, period=0.05, spec=disc)
    watch = PinnedWatch(robot.pose)
    for i in range(1, 40):
        robot.pose = Pose2(0.0, 0.0, wrap(3.0 + 0.06 * i))
        watch.note(robot, False)
        assert not watch.is_pinned
    for _ in range(20):
        watch.note(robot, False)
    assert watch.is_pinned
