"""Opening and closing the fingers, with broken readings of their opening."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.primitives.motions.grip import open_to
from handcart.primitives.outcomes.discrepancy import Discrepancy


def robot_with(widths: list[float]) -> Any:
    """Return a stub of a robot whose fingers have these openings in [m], the last one for good."""
    gripper = SimpleNamespace(move=lambda _: None, width=lambda: widths.pop(0) if widths[1:] else widths[0])
    return SimpleNamespace(
        gripper=gripper, spec=SimpleNamespace(gripper=SimpleNamespace(opening_mm=80.0)), time=0.0
    )


def test_fingers_are_not_open_before_their_opening_is_read() -> None:
    assert len(list(open_to(robot_with([0.02, math.nan, math.nan, 0.05, 0.08])))) == 4


def test_an_opening_that_is_never_read_is_a_failure() -> None:
    robot = robot_with([math.nan])
    with pytest.raises(Discrepancy, match="the fingers don't open") as stuck:
        for _ in open_to(robot):
            robot.time += 0.05
    assert stuck.value.cause.name == "fingers_stuck"
