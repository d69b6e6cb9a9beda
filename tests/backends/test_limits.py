"""Commands that no robot receives, whatever its backend."""

from __future__ import annotations

import math

import pytest

from handcart.backends.backend import CommandError
from handcart.backends.limits import checked_drive
from handcart.backends.loading.robot_loading import load_robot


@pytest.mark.parametrize("robot", ["librarian", "el_verde"])
def test_speeds_and_turns_have_to_be_within_the_drives(robot: str) -> None:
    """NaN is within nothing."""
    drive = load_robot(robot).drive
    top, top_turn = drive.top_speed_m_s, math.radians(drive.top_turn_deg_s)
    assert checked_drive(drive, -top, 0.0) == (-top, 0.0)
    for speed, turn_rate in (
        (1.01 * top, 0.0),
        (-1.01 * top, 0.0),
        (math.nan, 0.0),
        (0.0, math.nan),
        (math.inf, 0.0),
        (top, 1.01 * top_turn),
    ):
        with pytest.raises(CommandError, match="allowed: -"):
            checked_drive(drive, speed, turn_rate)


def test_a_car_turns_no_sharper_than_its_steering_and_not_on_the_spot() -> None:
    drive = load_robot("el_verde").drive
    sharpest = drive.sharpest_per_m * 0.2
    assert checked_drive(drive, 0.2, sharpest) == (0.2, sharpest)
    assert checked_drive(drive, -0.2, sharpest) == (-0.2, sharpest)
    for speed, turn_rate in ((0.2, 1.01 * sharpest), (0.2, -1.01 * sharpest), (0.0, 0.01)):
        with pytest.raises(CommandError, match="a curvature of"):
            checked_drive(drive, speed, turn_rate)
    assert checked_drive(load_robot("librarian").drive, 0.0, 0.5) == (0.0, 0.5)
