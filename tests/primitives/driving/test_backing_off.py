"""Backing off from what holds the base, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from handcart.primitives.driving.backing_off import BACK_OFF_M, BACK_OFF_MAX_TRIES, BackingOff
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


def test_backing_off_ends_after_its_tries_until_they_are_reset(make_rig: Callable[..., Rig]) -> None:
    backing_off, robot = BackingOff(), make_rig().robot
    for _ in range(BACK_OFF_MAX_TRIES):
        assert backing_off.may_try
        next(backing_off.drive(robot, False))
    assert not backing_off.may_try
    backing_off.tries = 0
    assert backing_off.may_try
