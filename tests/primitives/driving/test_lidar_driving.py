"""Driving by a lidar as its driver delivers it, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from pydantic import PrivateAttr

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from tests.primitives.conftest import Rig

BOX = "surprises:\n  - {{name: box, x_m: {x}, y_m: {y}, size_m: [0.4, 0.4, 0.6]}}\n"
HALF = {"beams": 181, "start_deg": -90.0, "end_deg": 90.0, "range_min_m": 0.1}
FAULTS = dict.fromkeys(
    ("range_zero_percent", "range_nan_percent", "range_too_close_percent", "range_own_body_percent"), 5.0
)
NEAR = 0.12  # [m] that the base may go into ground that it does not see


class Drive(ActionPrimitive):
    """Drive ahead, then back, for some periods each; keep the reason that holds it at the end."""

    ahead: int
    back: int
    _held: str = PrivateAttr(default="")

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for speed, periods in ((0.3, self.ahead), (-0.3, self.back)):
            for _ in range(periods):
                robot.base.drive(speed, 0.0)
                yield
        self._held = robot.held.words if robot.held else ""


class DriveOn(ActionPrimitive):
    """Drive ahead, and fail then."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(100):
            robot.base.drive(0.4, 0.0)
            yield
        raise Discrepancy("that is all")


@pytest.mark.slow
def test_missing_and_wrong_beams_do_not_end_a_drive(make_rig: Callable[..., Rig]) -> None:
    """5 % each of the scan are zeros, NaN, -inf and the robot's own body; it docks at the shelf as well."""
    rig = make_rig(lidar=HALF, errors=FAULTS, seed=1)
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert abs(rig.scene.base.y - 4.93) < 0.006
    assert rig.scene.contacts == []


@pytest.mark.slow
def test_with_wrong_beams_what_stands_in_the_way_is_still_a_fail(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX.format(x=3.0, y=1.1), lidar=HALF, errors=FAULTS)
    failed = rig.run(MoveTo(place="shelf_1", wait_s=1.0, detour=False))
    assert isinstance(failed, Fail)
    assert "an obstacle is on the path to shelf_1" in failed.reason
    assert math.dist(rig.scene.base[:2], (1.0, 1.0)) < 0.05
    assert rig.scene.contacts == []


@pytest.mark.parametrize("ahead", [0, 60])
def test_it_drives_back_where_it_drove_and_no_farther(make_rig: Callable[..., Rig], ahead: int) -> None:
    """A box that a half turn's lidar can't see is 0.6 m behind where it begins."""
    rig = make_rig(BOX.format(x=1.0, y=2.6), start_y=4.0, lidar=HALF)
    drive = Drive(ahead=ahead, back=ahead + 80)
    assert isinstance(rig.run(drive), Success)
    assert 4.0 - NEAR < rig.scene.base.y < 4.0
    assert "does not see the ground" in drive._held
    assert rig.scene.contacts == []


def test_with_a_view_all_round_it_drives_back_until_it_sees_something(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX.format(x=1.0, y=2.6), start_y=4.0)
    drive = Drive(ahead=0, back=80)
    rig.run(drive)
    assert rig.scene.base.y < 3.3
    assert "the scan shows something" in drive._held


def test_brought_back_it_drives_over_ground_that_it_drove_over(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(lidar=HALF, errors=FAULTS)
    assert isinstance(rig.run(DriveOn()), Fail)
    assert math.dist(rig.scene.base[:2], (1.0, 1.0)) < 0.05


@pytest.mark.parametrize(("width", "drives"), [(8, True), (60, False)])
def test_a_masked_sector_ahead_is_not_free_ground(
    make_rig: Callable[..., Rig], width: float, drives: bool
) -> None:
    rig = make_rig(lidar={"masked_deg": ((-width / 2, width / 2),)})
    rig.run(Drive(ahead=40, back=0))
    assert (rig.scene.base.y > 1.5) is drives
    assert (rig.scene.base.y < 1.0 + NEAR) is not drives


@pytest.mark.parametrize(
    ("errors", "localizer", "words"),
    [
        ({"range_nan_percent": 90.0}, "scan", "the lidar is blocked or dirty: of 360 beams 0 are too close"),
        ({"range_own_body_percent": 98.0}, "scan", "the lidar is blocked or dirty"),
        ({"range_too_close_percent": 90.0}, "odometry", "give no reading"),
        ({"range_zero_percent": 99.0}, "scan", "the lidar gets next to no echoes"),
        ({"range_zero_percent": 100.0}, "odometry", "the lidar gets too few echoes"),
    ],
)
def test_a_blocked_lidar_is_said_and_is_no_obstacle(
    make_rig: Callable[..., Rig], errors: dict[str, float], localizer: str, words: str
) -> None:
    rig = make_rig(errors=errors, localizer=localizer)
    ended = rig.run(MoveTo(place="shelf_1"))
    assert isinstance(ended, GiveUp)
    assert words in ended.reason
    assert "obstacle" not in ended.reason
    assert rig.robot.time < 10.0
    assert rig.scene.contacts == []


@pytest.mark.slow
def test_where_walls_are_beyond_the_reach_silence_is_no_fault(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(lidar={"reach_m": 1.2}, localizer="odometry")
    ended = rig.run(MoveTo(place="shelf_1"))
    assert rig.robot.time > 15.0  # it drove there, though wheels alone don't determine how exactly
    assert "lidar" not in getattr(ended, "reason", "")


@pytest.mark.parametrize("kept", [True, False])
def test_where_it_drove_is_in_a_checkpoint(make_rig: Callable[..., Rig], kept: bool) -> None:
    rig = make_rig(lidar=HALF)
    rig.run(Drive(ahead=60, back=0))
    state = rig.robot.state()
    rig.robot.set_state({**state, "driven": {"_driven": []}})
    if kept:
        rig.robot.set_state(state)
    rig.run(Drive(ahead=0, back=60))
    assert (rig.scene.base.y < 1.0 + NEAR) is kept
    assert "driven" not in make_rig().robot.state()


def test_it_does_not_creep_into_unseen_ground_attempt_by_attempt(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(start_y=4.0, lidar=HALF)
    for _ in range(4):
        rig.run(Drive(ahead=0, back=20))
        assert rig.scene.base.y > 4.0 - NEAR
