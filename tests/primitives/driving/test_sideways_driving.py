"""MOVE_TO with a base that drives in any direction."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Fail, Success
from tests.primitives.conftest import Rig

BOX = "surprises:\n  - {name: box, x_m: 4.5, y_m: 1.2, heading_deg: 20, size_m: [0.5, 0.4, 0.6]}\n"
LOW_STEP = "  - {name: step, x_m: 1.0, y_m: 1.8, heading_deg: 0, size_m: [1.0, 0.2, 0.15]}\n"


def note_sideways_speeds(rig: Rig) -> list[float]:
    """Return a list that gets the speed sideways of each period of the rig, in [m/s]."""
    speeds: list[float] = []
    step = rig.robot.step

    def step_and_note(paused: bool = False) -> None:
        step(paused)
        speeds.append(rig.robot.command.sideways)

    rig.robot.step = step_and_note  # type: ignore[method-assign]
    return speeds


@pytest.mark.slow
def test_it_docks_square_and_drives_sideways_on_the_way(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(seed=3, robot="cart/mecanum")
    speeds = note_sideways_speeds(rig)
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert abs(rig.scene.base.y - 4.93) < 0.006
    assert abs(rig.scene.base.x - 6.5) < 0.04
    assert abs(rig.scene.base.theta - math.pi / 2) < math.radians(0.4)
    assert np.abs(speeds).sum() * rig.robot.period > 0.3


@pytest.mark.slow
def test_a_blocked_drive_is_restored_to_where_it_began(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX, robot="cart/mecanum")
    before = rig.scene.base
    failed = rig.run(MoveTo(place="shelf_1", wait_s=1.0, detour=False))
    assert isinstance(failed, Fail), failed
    assert "an obstacle is on the path" in failed.reason
    assert before.distance(rig.scene.base) < 0.03
    assert before.turn(rig.scene.base) < math.radians(1.5)


def test_a_low_step_beside_is_felt_with_its_direction(make_rig: Callable[..., Rig]) -> None:
    """It turns to the right, and drives with its left side against what the lidar looks over."""
    rig = make_rig(furniture=LOW_STEP, robot="cart/mecanum")
    found = None
    for number in range(120):
        turns = rig.robot.pose.theta > 0.02 and number < 60
        rig.robot.base.drive(0.0, -1.0 if turns else 0.0, 0.0 if turns else 0.3)
        rig.robot.step()
        found = found or rig.robot.progress.blocked
    assert found is not None
    assert abs(found.direction - math.pi / 2) < 1e-6
    assert abs(found.heading - math.pi / 2) < 0.1
    assert found.moved < 0.25 * found.commanded
