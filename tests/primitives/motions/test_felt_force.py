"""The force on the hand, with periods in which the sensor reads no number."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.primitives.motions.felt_force import MAX_SILENT_PERIODS, FeltForce, awaited_force
from handcart.primitives.outcomes.discrepancy import Discrepancy

FORCE, NONE = np.array([0.0, 0.0, -4.0]), np.array([0.0, np.nan, -4.0])


def robot_with(readings: Sequence[Any]) -> Any:
    """Return a stub of a robot whose hand has these forces, one after the other."""
    each = iter(readings)
    return SimpleNamespace(arm=SimpleNamespace(hand_force=lambda: next(each)))


def test_a_force_is_awaited_while_none_is_read() -> None:
    periods = awaited_force(robot_with([*[NONE] * MAX_SILENT_PERIODS, FORCE]))
    for _ in range(MAX_SILENT_PERIODS):
        next(periods)
    with pytest.raises(StopIteration) as end:
        next(periods)
    assert end.value.value is FORCE


def test_a_sensor_that_stays_silent_is_a_fault() -> None:
    with pytest.raises(Discrepancy, match="the force on the hand isn't measured") as fault:
        list(awaited_force(robot_with([NONE] * 20)))
    assert fault.value.cause.name == "sensor_fault"


def test_single_missing_readings_do_not_add_up() -> None:
    felt = FeltForce(robot_with([NONE, FORCE] * 20))
    assert [felt.read() is None for _ in range(40)] == [True, False] * 20
