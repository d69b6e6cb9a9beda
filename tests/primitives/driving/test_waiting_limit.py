"""Drives in which something changes again and again: the waits are added up, and every drive ends."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.primitives.driving import orient, waiting_limit
from handcart.primitives.driving.driving import ObstacleMonitor
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.driving.orient import Orient
from handcart.primitives.driving.waiting_limit import WAITING_LIMIT_S, WaitingLimit
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from tests.primitives.conftest import Rig

PERIOD = 0.05
AHEAD = Place(x_m=1.0, y_m=4.0, heading_deg=90.0)


def periods_until_the_limit(limit: WaitingLimit, remaining: Callable[[int], float]) -> int:
    robot: Any = SimpleNamespace(period=PERIOD)
    for number in range(100_000):
        try:
            limit.note(robot, remaining(number), waits=number % 2 == 0)
        except Discrepancy as found:
            assert found.cause is causes.BLOCKED
            return number
    return -1


def test_interrupted_waits_are_added_up() -> None:
    found = periods_until_the_limit(WaitingLimit("desk", 5.0), lambda _: 3.0)
    assert found == pytest.approx(2.0 * WAITING_LIMIT_S / PERIOD, abs=3)


def test_longer_wait_for_one_obstacle_has_a_longer_limit() -> None:
    found = periods_until_the_limit(WaitingLimit("desk", 600.0), lambda _: 3.0)
    assert found == pytest.approx(2.0 * 1200.0 / PERIOD, abs=3)


def test_waits_of_a_drive_that_gets_nearer_have_no_limit() -> None:
    assert periods_until_the_limit(WaitingLimit("desk", 5.0), lambda number: 1e3 - 1e-4 * number) == -1


@pytest.mark.parametrize("limit_s", [12.0, 300.0])
def test_obstacle_that_comes_and_goes_ends_the_drive(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch, limit_s: float
) -> None:
    """It leaves for a period, twelve times, before `wait_s` has passed; the drive waits no longer in total
    than the limit.
    """
    rig = make_rig(robot="cart")
    rig.model.places = {**rig.model.places, "ahead": AHEAD}
    looks = {"count": 0}

    def obstacle(*_: object) -> Any:
        looks["count"] += 1
        comes = looks["count"] < 12 * 40 and looks["count"] % 40
        return (0.3, np.array([1.0, 3.0])) if comes else None

    monkeypatch.setattr(ObstacleMonitor, "obstacle", obstacle)
    monkeypatch.setattr(waiting_limit, "WAITING_LIMIT_S", limit_s)
    outcome = rig.run(MoveTo(place="ahead", detour=False))
    if limit_s > 24.0:
        assert isinstance(outcome, Success)
        return
    assert isinstance(outcome, Fail)
    assert "has to wait again and again" in outcome.reason
    assert outcome.cause is causes.BLOCKED


@pytest.mark.parametrize("flickers", [False, True])
def test_orient_ends_though_the_base_is_held_again_and_again(flickers: bool) -> None:
    held = SimpleNamespace(words="the scan shows something", room=0.1, needed=0.3)
    robot: Any = SimpleNamespace(
        time=0.0,
        period=PERIOD,
        drive_limits=DriveLimits(),
        driven=(0.0, 0.0),
        held=held,
        localization=SimpleNamespace(heading_known=False),
        base=SimpleNamespace(drive=lambda *_: None),
    )
    model: Any = SimpleNamespace()
    with pytest.raises(Discrepancy) as ended:
        for number, _ in enumerate(Orient().motion(robot, model)):
            robot.time += PERIOD
            robot.held = None if flickers and number % 100 == 0 else held
            assert robot.time < 2.0 * orient.STANDING_TIMEOUT_S
    assert ended.value.cause is (causes.NO_PROGRESS if flickers else causes.BLOCKED)
