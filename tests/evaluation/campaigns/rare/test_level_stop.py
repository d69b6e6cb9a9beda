"""Counts of a run in a rare-event estimate, and the level at which it is stopped."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from handcart.evaluation.campaigns.rare.level_stop import LevelStop
from handcart.networks.events.events import Ended, Restoring
from handcart.networks.graph.network import Action
from handcart.primitives.outcomes.outcome import Outcome, Success, fail_if_restored
from handcart.primitives.outcomes.residual import read_residuals

DRIVE = Action("a", "b", None, attempts=3, index=4)


def ended(permanent: bool | None = None) -> Ended:
    """Return the end of the same action: a Success, or a Fail that uses up one attempt or all."""
    primitive: Any = SimpleNamespace()
    outcome: Outcome = Success({})
    if permanent is not None:
        outcome = fail_if_restored("it stalled", permanent, read_residuals({}, {}))
    return Ended(1.0, 1, DRIVE, primitive, outcome, {})


class Stopped:
    """Interrupts that count how often the run was stopped."""

    def __init__(self) -> None:
        self.count = 0

    def stop(self) -> None:
        self.count += 1


@pytest.fixture
def heard() -> Any:
    return Stopped()


def test_level_stop_counts_each_action_that_ended(heard: Any) -> None:
    level = LevelStop("fails", 9, heard, {})
    for event in (ended(), ended(False), Restoring(1.0, DRIVE, "it stalled"), ended()):
        level.event(event)
    assert (level.steps, dict(level.used), heard.count) == (3, {4: 1}, 0)


def test_level_stop_stops_at_its_level_and_not_before(heard: Any) -> None:
    level = LevelStop("fails", 2, heard, {})
    level.event(ended(False))
    assert (level.near, heard.count) == (False, 0)
    level.event(ended(False))
    assert (level.near, heard.count) == (True, 1)


def test_level_stop_continues_with_attempts_used_before(heard: Any) -> None:
    level = LevelStop("fails", 2, heard, {4: 1})
    level.event(ended(False))
    assert (dict(level.used), heard.count) == ({4: 2}, 1)


@pytest.mark.parametrize(("importance", "used"), [("attempts", 3), ("fails", 1)])
def test_level_stop_permanent_fail_uses_up_attempts(heard: Any, importance: Any, used: int) -> None:
    level = LevelStop(importance, 9, heard, {})
    level.event(ended(True))
    assert level.used[4] == used
