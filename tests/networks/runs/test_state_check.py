"""Measuring and confirming the state of a robot before its run is resumed."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.joint_units import JointUnits
from handcart.networks.journal.retracing import NeedsOperator
from handcart.networks.runs.resuming import Past
from handcart.networks.runs.state_check import (
    SETTLING_PERIODS,
    StateCheck,
    check_state,
    gone_on,
    standing_as_left,
)
from handcart.primitives.outcomes.residual import read_residuals
from handcart.primitives.restoring.snapshot import REST_PERIODS
from tests.networks.runs.conftest import UnfinishedRun


def found(past: Past, values: dict[str, float], sure: bool = True) -> StateCheck:
    at = past.standing.at
    assert at is not None
    return StateCheck(
        at, at, read_residuals(values, dict.fromkeys(values, 1.0)), (), sure, JointUnits((), (), ())
    )


def test_robot_at_another_place_does_not_resume_when_confirmed(run: UnfinishedRun) -> None:
    """U13"""
    run.cut("START", 1)
    run.forget()
    past = run.past()
    for off in ({"base_mm": 150.0}, {"base_mm": math.nan}):
        with pytest.raises(NeedsOperator, match="the robot isn't where it was left: base_mm"):
            gone_on(past, found(past, off), past.last)
    assert gone_on(past, found(past, {"base_mm": 0.5}), past.last).closing[0][0] == "RECON"


@pytest.mark.parametrize("confirm", [None, -1, 1])
def test_only_the_last_record_confirms(run: UnfinishedRun, confirm: int | None) -> None:
    run.cut("START", 1)
    run.forget()
    past = run.past()
    with pytest.raises(NeedsOperator, match=f"--confirm {past.last}"):
        gone_on(past, found(past, {}), confirm and past.last + confirm)


def test_action_in_doubt_measured_at_its_start_has_failed(run: UnfinishedRun) -> None:
    run.cut("RESULT", 1)
    run.forget()
    past = run.past()
    after = gone_on(past, found(past, {"base_mm": 0.1}), past.last)
    kind, closed = after.closing[1]
    assert (kind, closed["n"], closed["outcome"], closed["by"]) == ("RESULT", 2, "Fail", "recon")
    assert (after.standing.in_doubt, after.standing.fails) == (None, 1)


@pytest.mark.parametrize("why", ["an intent is open", "nobody is sure"])
def test_what_no_sensor_tells_a_person_has_to_acknowledge(run: UnfinishedRun, why: str) -> None:
    run.cut("RESULT", 1)
    run.forget()
    if why == "an intent is open":
        run.append("INTENT", n=2, effect="the fingers let the book go")
    past = run.past()
    assert past.standing.in_doubt is not None
    with pytest.raises(NeedsOperator, match=rf"no sensor .*: handcart ack \S+ {past.standing.in_doubt['q']}"):
        gone_on(past, found(past, {}, sure=why != "nobody is sure"), past.last)


def test_the_estimate_goes_on_where_and_when_the_journal_left_it(run: UnfinishedRun) -> None:
    run.cut("START", 2)
    run.forget()
    past, prepared = run.past(), run.prepare()
    robot = standing_as_left(prepared, past).robot
    assert past.standing.at is not None
    assert robot.pose.distance(past.standing.at.pose) < 1e-9
    assert robot.pose.x == pytest.approx(10 * 0.05 * 0.2, abs=1e-3)
    assert robot.time == past.time_s > 0.5


def test_by_wheels_alone_nobody_knows_where_the_base_stands(run: UnfinishedRun) -> None:
    """They were not heard meanwhile: that they agree with themselves says nothing."""
    run.cut("START", 2)
    run.forget()
    past = run.past()
    check = check_state(standing_as_left(run.prepare(), past).robot, past)
    assert not check.sure
    assert not any(name.startswith("base") for name in check.residuals)
    assert any(item.startswith("the pose of the base: only its wheels measure it") for item in check.unknown)


@pytest.mark.parametrize("rolls", [0, 3])
def test_a_look_waits_until_the_robot_rests(
    run: UnfinishedRun, monkeypatch: pytest.MonkeyPatch, rolls: int
) -> None:
    """Two seconds, then until nothing moves; nothing is commanded."""
    run.cut("START", 2)
    run.forget()
    past, prepared = run.past(), run.prepare()
    robot = standing_as_left(prepared, past).robot
    wheels: Any = prepared.backend.capabilities()[0]
    stepped, step = [0], robot.step

    def rolling(*paused: bool) -> None:
        stepped[0] += 1
        if SETTLING_PERIODS < stepped[0] <= SETTLING_PERIODS + rolls:
            left, right, _ = wheels.travel
            wheels.travel = WheelTravel(left + 0.01, right + 0.01)
        step(*paused)

    monkeypatch.setattr(robot, "step", rolling)
    monkeypatch.setattr(wheels, "drive", lambda *_: pytest.fail("nothing is commanded"))
    check = check_state(robot, past)
    assert stepped == [SETTLING_PERIODS + rolls + REST_PERIODS]
    assert check.measured.pose.x == pytest.approx(0.1 + 0.01 * rolls, abs=1e-3)
    assert check.expected is past.standing.at


def test_a_look_at_a_robot_of_which_nothing_is_known_says_so(run: UnfinishedRun) -> None:
    run.cut("START", 0)
    run.forget()
    past = run.past()
    assert past.standing.at is None
    check = check_state(standing_as_left(run.prepare(), past).robot, past)
    assert (check.sure, len(check.residuals.beyond), check.expected) == (False, 0, None)
    assert check.unknown == ("the robot's state: not in the journal",)
    measured = r"measured: base at \(0\.00, 0\.00\) m, heading -?0\.0 deg; off by nothing known"
    assert re.fullmatch(measured, check.words()[0])
    assert check.fields()["expected"] is None
    past.check_robot(run.prepare().robot)


def test_a_journal_of_a_robot_with_other_joints_is_refused(run: UnfinishedRun) -> None:
    """Both the last snapshot and those of earlier situations count."""
    run.cut("START", 2)
    run.forget()
    past, robot = run.past(), run.prepare().robot
    past.check_robot(robot)
    assert past.standing.at is not None
    six = replace(past.standing.at, joints=np.zeros(6), joint_command=np.zeros(6))
    words = r"journal\.jsonl describes 6 joints, and the robot has 0$"
    seen = past.standing.seen
    for at in (replace(past.standing, at=six), replace(past.standing, seen={**seen, "b": six})):
        with pytest.raises(NeedsOperator, match=words):
            replace(past, standing=at).check_robot(robot)


def test_what_is_not_known_is_not_in_place(run: UnfinishedRun) -> None:
    check = found(run.past(), {"joints_deg": 0.9, "gripper_mm": math.nan, "held": math.inf})
    assert check.residuals.beyond.keys() == {"gripper_mm", "held"}
