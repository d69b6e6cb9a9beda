"""Tests of the framework's guarantees for every primitive, with tiny ones on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.primitives.contract.attempt import PUSHED_REASON
from handcart.primitives.knowledge.world_model import UndeclaredAccess
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.primitives.outcomes.residual import Residuals
from tests.primitives.conftest import Rig

from .waves import (
    Blind,
    BlindAfter,
    ComesShort,
    Inches,
    NotYet,
    Pusher,
    Rolls,
    Stubborn,
    Thinks,
    Watched,
    Wave,
    WithdrawsBadly,
    at,
    count_stops,
)


def test_success_carries_what_was_found(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    outcome = rig.run(Wave())
    assert outcome == Success({"swings": 1})
    assert rig.restored == []
    assert rig.robot.time == pytest.approx(1.5)  # 20 periods of motion, 5 at rest before and after
    assert rig.robot.failed_from is None


@pytest.mark.parametrize(
    ("end", "reason", "permanent"),
    [
        ("discrepancy", "the wave was not answered", False),
        ("for good", "nobody is there", True),
        ("a fault", "ZeroDivisionError: division by zero", False),
    ],
)
def test_a_fail_is_measured_where_everything_is_as_it_was(
    make_rig: Callable[..., Rig], end: str, reason: str, permanent: bool
) -> None:
    rig = make_rig(seed=1)
    start = at(rig)
    primitive = Wave(end=end)
    outcome = rig.run(primitive)
    assert isinstance(outcome, Fail)
    assert (outcome.reason, outcome.permanent) == (reason, permanent)
    assert outcome.residuals["base_mm"] < 25.0
    assert outcome.residuals["joints_deg"] < 0.3
    assert np.allclose(at(rig), start, atol=0.02)
    assert rig.restored == [reason]
    assert ("traceback" in primitive.facts) == (end == "a fault")


def test_nobody_else_makes_a_fail() -> None:
    with pytest.raises(TypeError, match="must be measured"):
        Fail("I say so", False, Residuals())


def test_a_person_needed_stops_where_it_is(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    start = at(rig)
    assert rig.run(Wave(end="a person")) == GiveUp("the arm squeaks")
    assert not np.allclose(at(rig), start, atol=0.02)
    here = at(rig)
    rig.drive(rig.robot.wait(0.5))
    assert at(rig) == here


def test_after_a_point_of_no_return_nothing_is_retraced(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    start = at(rig)
    primitive = Wave(end="no return")
    outcome = rig.run(primitive)
    assert isinstance(outcome, GiveUp)
    assert outcome.reason == "the wave was not answered; after a point of no return (it waved)"
    assert primitive.facts["finished"] == 1
    assert not np.allclose(at(rig), start, atol=0.02)


def test_an_effect_that_is_not_seen_is_a_fail(make_rig: Callable[..., Rig]) -> None:
    outcome = make_rig().run(Blind())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "success is not confirmed: the effect is not seen"


def test_an_effect_that_is_not_seen_after_no_return_is_for_a_person(make_rig: Callable[..., Rig]) -> None:
    outcome = make_rig().run(BlindAfter())
    assert isinstance(outcome, GiveUp)
    assert "the lamp is broken" in outcome.reason


@pytest.mark.parametrize("lost", [False, True])
def test_an_object_that_is_not_where_it_was_is_for_a_person(make_rig: Callable[..., Rig], lost: bool) -> None:
    outcome = make_rig().run(Pusher(lost=lost))
    assert isinstance(outcome, GiveUp)
    assert "not restored: object cup mm" in outcome.reason
    assert outcome.residuals["object cup mm"] == pytest.approx(math.inf if lost else 12.0)


def test_a_restore_that_misses_is_tried_again_by_the_framework(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    outcome = rig.run(Stubborn())
    assert isinstance(outcome, GiveUp)  # the arm isn't brought back by regulating the base
    assert outcome.reason.startswith("the wave was not answered; and not restored: joints_deg ")
    assert "base" not in outcome.reason
    assert rig.restored == ["the wave was not answered"]
    assert outcome.residuals["base_mm"] < 25.0


def test_withdrawing_that_fails_is_told_beside_what_failed_before(make_rig: Callable[..., Rig]) -> None:
    primitive = WithdrawsBadly(end="no return")
    outcome = make_rig().run(primitive)
    assert outcome == GiveUp(
        "the wave was not answered; and withdrawing: ValueError: it is stuck; "
        "after a point of no return (it waved)"
    )
    first, second = primitive.evidence.causes
    assert (first.check, first.restoring, first.fault) == ("motion", False, "")
    assert (second.check, second.restoring, second.fault) == ("finish", True, "ValueError")
    assert (first.calls, second.calls) == (("Wave.motion",), ("WithdrawsBadly.finish",))


@pytest.mark.parametrize(
    ("stage", "reason", "check"),
    [
        ("precondition", "the lamp is missing", "precondition"),
        ("unmet raises", "ValueError: nobody knows", "framework"),
    ],
)
def test_nothing_moves_before_the_start_is_allowed(
    make_rig: Callable[..., Rig], stage: str, reason: str, check: str
) -> None:
    rig = make_rig()
    before, stops = at(rig), count_stops(rig)
    primitive = NotYet(stage=stage)
    outcome = rig.run(primitive)
    assert isinstance(outcome, Fail)
    assert (outcome.reason, outcome.permanent, len(outcome.residuals)) == (reason, False, 0)
    assert [cause.check for cause in primitive.evidence.causes] == [check]
    assert (at(rig), rig.restored, len(stops)) == (before, [], 1)


def test_a_push_before_the_start_is_for_a_person(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    stops = count_stops(rig)
    primitive = NotYet(stage="pushed")
    assert rig.run(primitive) == GiveUp(PUSHED_REASON, cause=causes.DISPLACED)
    assert [(cause.reason, cause.check) for cause in primitive.evidence.causes] == [(PUSHED_REASON, "push")]
    assert len(stops) == 1


def test_a_robot_that_never_rests_does_not_start(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = make_rig()
    stops = count_stops(rig)
    base: Any = rig.robot.base
    ticks = iter(range(10_000))
    monkeypatch.setattr(type(base), "wheel_travel", lambda _: WheelTravel(0.01 * next(ticks), 0.0))
    primitive = Wave()
    words = "the robot doesn't come to rest before the start"
    assert rig.run(primitive) == GiveUp(words, cause=causes.NO_REST)
    assert [(cause.reason, cause.check) for cause in primitive.evidence.causes] == [(words, "rest")]
    assert (len(stops), primitive.facts) == (1, {})


def test_a_fail_stops_before_and_after_its_way_back(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    stops = count_stops(rig)
    assert isinstance(rig.run(Wave(end="discrepancy")), Fail)
    assert len(stops) == 2
    assert stops[0] == pytest.approx(1.25)  # 5 periods to settle, 20 of its motion
    assert stops[1] == rig.robot.time


@pytest.mark.parametrize(
    ("end", "outcome"),
    [
        ("returns", Success({"thought": 1})),
        ("discrepancy", "it makes no sense"),
        ("for good", "it never will"),
        ("a fault", "ZeroDivisionError: division by zero"),
        ("a person", GiveUp("who knows")),
    ],
)
def test_what_only_changes_knowledge_never_moves_or_waits(
    make_rig: Callable[..., Rig], end: str, outcome: Any
) -> None:
    rig = make_rig()
    primitive = Thinks(end=end)
    found = rig.run(primitive)
    assert rig.robot.time == pytest.approx(0.05)
    assert rig.restored == []
    causes = [(cause.check, cause.fault) for cause in primitive.evidence.causes]
    assert causes == [("motion", "ZeroDivisionError" if end == "a fault" else "")] * (end != "returns")
    assert ("traceback" in primitive.facts) == (end == "a fault")
    if isinstance(outcome, str):
        assert isinstance(found, Fail)
        assert (found.reason, found.permanent, len(found.residuals)) == (outcome, end == "for good", 0)
    else:
        assert found == outcome


def test_base_left_elsewhere_by_restoring_is_restored_again(
    make_rig: Callable[..., Rig],
) -> None:
    rig = make_rig()
    before = rig.scene.base
    assert isinstance(rig.run(Rolls()), Fail)
    assert rig.scene.base.distance(before) < 0.01


def test_raising_while_restoring_is_for_a_person(make_rig: Callable[..., Rig]) -> None:
    outcome = make_rig().run(Stubborn(raises=True))
    assert outcome == GiveUp("the wave was not answered; and restoring failed: the way back is blocked")


def test_the_watch_is_asked_in_motion_and_on_the_way_back(make_rig: Callable[..., Rig]) -> None:
    outcome = make_rig().run(Watched())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "somebody stands there"
    outcome = make_rig().run(Watched(also_back=True))
    assert isinstance(outcome, GiveUp)
    assert "restoring failed: somebody stands there" in outcome.reason


@pytest.mark.parametrize("period", [1, 8, 20])
def test_a_cancel_in_any_period_is_restored(make_rig: Callable[..., Rig], period: int) -> None:
    rig = make_rig()
    start, end = at(rig), rig.robot.time + 0.05 * period
    outcome = rig.run(Wave(), lambda: rig.robot.time >= end)
    assert isinstance(outcome, Fail)
    assert outcome.reason == "cancelled by the operator"
    assert np.allclose(at(rig), start, atol=0.02)


@pytest.mark.parametrize(("end", "what"), [("reads", "reads 'places'"), ("writes", "writes 'slot'")])
def test_what_was_not_declared_is_refused(make_rig: Callable[..., Rig], end: str, what: str) -> None:
    outcome = make_rig().run(Wave(end=end))
    assert isinstance(outcome, Fail)
    assert outcome.reason.startswith(UndeclaredAccess.__name__)
    assert what in outcome.reason


@pytest.mark.slow
@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_what_fails_leave_does_not_add_up(make_rig: Callable[..., Rig], localizer: str) -> None:
    rig = make_rig(localizer=localizer)
    before = rig.scene.base
    for _ in range(8):
        assert isinstance(rig.run(ComesShort()), Fail)
    assert rig.scene.base.distance(before) < 0.015


def test_after_a_success_fails_go_back_to_where_it_ended(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    assert isinstance(rig.run(ComesShort()), Fail)
    assert isinstance(rig.run(Inches()), Success)
    there = rig.scene.base
    assert isinstance(rig.run(Rolls()), Fail)
    assert rig.scene.base.distance(there) < 0.010


def test_where_the_first_fail_began_outlasts_a_crash(make_rig: Callable[..., Rig]) -> None:
    rig, other = make_rig(), make_rig()
    rig.run(ComesShort())
    kept = rig.robot.state()
    other.robot.set_state(kept)
    assert other.robot.failed_from is not None
    assert other.robot.failed_from == rig.robot.failed_from


@pytest.mark.slow
def test_thirty_fails_in_a_row_do_not_drift(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(seed=4)
    start = rig.scene.base
    joints = rig.robot.arm.command()
    for _ in range(30):
        assert isinstance(rig.run(Wave(end="discrepancy")), Fail)
    assert math.dist(start[:2], rig.scene.base[:2]) < 0.010
    assert abs(start.theta - rig.scene.base.theta) < math.radians(1.0)
    assert np.allclose(rig.robot.arm.command(), joints, atol=1e-9)
