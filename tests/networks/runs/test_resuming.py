"""Known state of a run that broke off, and the confirmations that a real robot needs to resume."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.joint_units import JointUnits
from handcart.backends.saved_state import NotAState, pack
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.graph.planner import Plan
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import NeedsOperator, standing
from handcart.networks.journal.waiting import waiting
from handcart.networks.run_files.run_folder import read_run_journal
from handcart.networks.runs.checkpoint import CHECKPOINT_FILE, keep_checkpoint, load_checkpoint
from handcart.networks.runs.resuming import NothingToResume, Past, read_past, task_of
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.runs.state_check import (
    SETTLING_PERIODS,
    StateCheck,
    check_state,
    gone_on,
    standing_as_left,
)
from handcart.networks.task.preparing import Prepared
from handcart.networks.task.task_file import load_task
from handcart.primitives.outcomes.residual import read_residuals
from handcart.primitives.restoring.snapshot import REST_PERIODS
from tests.networks.conftest import Stand

_OWN = ("kind", "q", "t", "wall", "p", "h")
"""Fields that the journal itself writes into each record."""
TASK = """\
format: handcart-task/1
title: Drive three times
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, c: {}, z: {}}
actions:
  - {do: DRIVE, from: a, to: b, cost_s: 1, with: {periods: 4}}
  - {do: DRIVE, from: b, to: c, cost_s: 1, with: {periods: 6}}
  - {do: DRIVE, from: c, to: z, cost_s: 1, with: {periods: 8}}
  - {do: DRIVE, from: a, to: z, cost_s: 9, with: {periods: 8}}
"""


class Run:
    """A real robot's run, over: its folder and network, and the state from which it would resume."""

    def __init__(self, folder: Path, prepare: Callable[[], Prepared]) -> None:
        self.folder, self.prepare = folder, prepare
        prepared = prepare()
        self.network, self.model = prepared.task.network, prepared.model
        execute(prepared, folder, RunOptions(checkpoints=True, sync=False))

    @property
    def records(self) -> tuple[Any, ...]:
        return read_journal(self.folder / "journal.jsonl").records

    def cut(self, kind: str, number: int, half: bool = False) -> None:
        """Broken off before the `number`-th record of a kind, or in the middle of it."""
        path = self.folder / "journal.jsonl"
        lines = path.read_bytes().splitlines(keepends=True)
        place = [i for i, line in enumerate(lines) if f'"kind":"{kind}"'.encode() in line][number]
        torn = lines[place][: len(lines[place]) // 2] if half else b""
        path.write_bytes(b"".join(lines[:place]) + torn)

    def append(self, kind: str, **fields: Any) -> None:
        path = self.folder / "journal.jsonl"
        with Journal.go_on(path, read_journal(path), "never") as journal:
            journal.append(kind, 9.0, fields)

    def forget(self) -> None:
        (self.folder / CHECKPOINT_FILE).unlink()

    def past(self) -> Past:
        return read_past(self.folder, self.network)


@pytest.fixture
def run(tmp_path: Path, new_stand: Callable[[], Stand], primitives: SimpleNamespace) -> Run:
    path = tmp_path / "task" / "task.yaml"
    path.parent.mkdir()
    path.write_text(TASK)
    task = load_task(path, {}, lambda name: getattr(primitives, name))

    def prepare() -> Prepared:
        stand = new_stand()
        stand.backend.simulated = False
        return Prepared(task, "two_wheels", stand.backend, stand.robot, stand.model, 7, {}, ())

    return Run(tmp_path / "run", prepare)


def found(past: Past, values: dict[str, float], sure: bool = True) -> StateCheck:
    at = past.standing.at
    assert at is not None
    return StateCheck(
        at, at, read_residuals(values, dict.fromkeys(values, 1.0)), (), sure, JointUnits((), (), ())
    )


def test_a_result_that_only_the_checkpoint_holds_counts(run: Run) -> None:
    run.cut("RESULT", -1)
    past = run.past()
    assert past.recovered is not None
    assert (past.recovered["n"], past.recovered["outcome"]) == (3, "Success")
    assert past.standing.route.arrived


def test_a_checkpoint_that_follows_another_record_is_not_the_journals(run: Run) -> None:
    run.cut("RESULT", -1)
    run.append("INTENT", n=3, effect="the lamp goes out")
    with pytest.raises(NeedsOperator, match="is not the one that its journal names: it is of action 3"):
        run.past()


def test_a_torn_record_may_have_been_the_start_of_the_next_action(run: Run) -> None:
    """D3"""
    run.cut("START", 1, half=True)
    run.forget()
    past = run.past()
    assert past.standing.in_doubt is not None
    assert past.standing.in_doubt["n"] == 2
    assert list(past.doubts()) == [
        "how far action 2, DRIVE from b, had come",
        f"the content of record {past.last + 1}, which is damaged",
    ]


@pytest.mark.parametrize("outcome", ["Success", "Fail"])
def test_a_run_that_came_to_its_end_is_over(run: Run, outcome: str) -> None:
    run.cut("END", 0)
    assert task_of(run.folder)["network"] == run.network.fingerprint()
    run.append("END", outcome=outcome, situation="c", reason="no way")
    with pytest.raises(NothingToResume, match=f"is over: {outcome} in situation c"):
        task_of(run.folder)


@pytest.mark.parametrize("outcome", ["Cancelled", "GiveUp", "Error"])
def test_one_that_was_stopped_or_gave_up_is_not(run: Run, outcome: str) -> None:
    run.cut("END", 0)
    run.append("END", outcome=outcome, situation="c", reason="asked for")
    assert task_of(run.folder)["start"] == "a"


def test_robot_at_another_place_does_not_resume_when_confirmed(run: Run) -> None:
    """U13"""
    run.cut("START", 1)
    run.forget()
    past = run.past()
    for off in ({"base_mm": 150.0}, {"base_mm": math.nan}):
        with pytest.raises(NeedsOperator, match="the robot isn't where it was left: base_mm"):
            gone_on(past, found(past, off), past.last)
    assert gone_on(past, found(past, {"base_mm": 0.5}), past.last).closing[0][0] == "RECON"


@pytest.mark.parametrize("confirm", [None, -1, 1])
def test_only_the_last_record_confirms(run: Run, confirm: int | None) -> None:
    run.cut("START", 1)
    run.forget()
    past = run.past()
    with pytest.raises(NeedsOperator, match=f"--confirm {past.last}"):
        gone_on(past, found(past, {}), confirm and past.last + confirm)


def test_action_in_doubt_measured_at_its_start_has_failed(run: Run) -> None:
    run.cut("RESULT", 1)
    run.forget()
    past = run.past()
    after = gone_on(past, found(past, {"base_mm": 0.1}), past.last)
    kind, closed = after.closing[1]
    assert (kind, closed["n"], closed["outcome"], closed["by"]) == ("RESULT", 2, "Fail", "recon")
    assert (after.standing.in_doubt, after.standing.fails) == (None, 1)


@pytest.mark.parametrize("why", ["an intent is open", "nobody is sure"])
def test_what_no_sensor_tells_a_person_has_to_acknowledge(run: Run, why: str) -> None:
    run.cut("RESULT", 1)
    run.forget()
    if why == "an intent is open":
        run.append("INTENT", n=2, effect="the fingers let the book go")
    past = run.past()
    assert past.standing.in_doubt is not None
    with pytest.raises(NeedsOperator, match=rf"no sensor .*: handcart ack \S+ {past.standing.in_doubt['q']}"):
        gone_on(past, found(past, {}, sure=why != "nobody is sure"), past.last)


def test_the_estimate_goes_on_where_and_when_the_journal_left_it(run: Run) -> None:
    run.cut("START", 2)
    run.forget()
    past, prepared = run.past(), run.prepare()
    robot = standing_as_left(prepared, past).robot
    assert past.standing.at is not None
    assert robot.pose.distance(past.standing.at.pose) < 1e-9
    assert robot.pose.x == pytest.approx(10 * 0.05 * 0.2, abs=1e-3)
    assert robot.time == past.time_s > 0.5


def test_by_wheels_alone_nobody_knows_where_the_base_stands(run: Run) -> None:
    """They were not heard meanwhile: that they agree with themselves says nothing."""
    run.cut("START", 2)
    run.forget()
    past = run.past()
    check = check_state(standing_as_left(run.prepare(), past).robot, past)
    assert not check.sure
    assert not any(name.startswith("base") for name in check.residuals)
    assert any(item.startswith("the pose of the base: only its wheels measure it") for item in check.unknown)


@pytest.mark.parametrize("rolls", [0, 3])
def test_a_look_waits_until_the_robot_rests(run: Run, monkeypatch: pytest.MonkeyPatch, rolls: int) -> None:
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


def test_a_look_at_a_robot_of_which_nothing_is_known_says_so(run: Run) -> None:
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


def test_a_journal_of_a_robot_with_other_joints_is_refused(run: Run) -> None:
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


def test_what_is_known_and_what_comes_next_is_told(run: Run) -> None:
    run.cut("START", 2)
    run.forget()
    past = run.past()
    wall = past.contents.records[-1]["wall"]["unix_s"]
    boot = past.contents.records[0]["wall"]["boot_id"]
    known = f"known: record {past.last}, 7 s ago; situation c, 2 actions started, 0 failed"
    assert past.words(wall + 7.2, boot) == [known]
    assert past.words(wall + 7.2, "another") == [known, "known: the machine was restarted since"]
    assert past.words(wall - 7.2, boot)[0].startswith(f"known: record {past.last}, 0 s ago")
    assert past.next_words() == "next: DRIVE (c to z)"
    assert past.recovered is None
    (epoch,) = past.resume_records
    assert epoch == ("EPOCH", {"after": past.last, "in_doubt": None}, {})


def test_age_of_a_run_is_that_of_its_last_record(run: Run) -> None:
    run.cut("START", 2)
    run.forget()
    past = run.past()
    for number, record in enumerate(past.contents.records):
        record["wall"]["unix_s"] = 100.0 * number
    written = 100.0 * (len(past.contents.records) - 1)
    assert past.words(written + 7.2, None)[0].startswith(f"known: record {past.last}, 7 s ago")


def test_a_recovered_result_and_a_torn_tail_are_told(run: Run) -> None:
    run.cut("RESULT", -1, half=True)
    past = run.past()
    lines = past.words(0.0, None)
    assert lines[1:3] == [
        f"torn: the journal's tail from byte {past.contents.torn_at} on is set aside",
        "recovered: action 3 had ended with Success",
    ]
    assert past.checkpoint is not None
    (kind, fields, wall), epoch = past.resume_records
    assert (kind, fields["n"], fields["recovered"]) == ("RESULT", 3, True)
    assert wall == {"checkpoint": past.checkpoint.digest}
    assert epoch[1]["in_doubt"] is None
    assert past.next_words() == "next: nothing, the goal is reached"


def test_no_way_left_is_what_comes_next(run: Run) -> None:
    run.cut("START", 0)
    run.forget()
    for number, index in enumerate((0, 3), 1):
        action = run.network.actions[index]
        words = {"index": index, "do": action.do, "from": action.source, "to": action.target}
        run.append("START", n=number, action={**words, "with": {}})
        failed = {"outcome": "Fail", "reason": "blocked", "permanent": True, "residuals": {}}
        run.append("RESULT", n=number, **failed)
        if number == 1:
            run.append("PLAN", situation="a", way=[3], cost=9.0, excluded=[0])
    past = run.past()
    assert past.next_words().startswith("next: no way left from a to z: ")
    assert (past.standing.started, past.standing.fails, past.standing.plans) == (2, 2, 2)


def test_what_is_not_known_is_not_in_place(run: Run) -> None:
    check = found(run.past(), {"joints_deg": 0.9, "gripper_mm": math.nan, "held": math.inf})
    assert check.residuals.beyond.keys() == {"gripper_mm", "held"}


def test_a_give_up_leaves_the_checkpoint_before_it(run: Run) -> None:
    """The person who acknowledges it has put everything back as it was before that action."""
    before = (run.folder / CHECKPOINT_FILE).read_bytes()
    keep = partial(keep_checkpoint, run.folder, run.prepare(), False)
    assert keep({"n": 4, "outcome": "GiveUp", "reason": "stuck"}, "x") is None
    assert (run.folder / CHECKPOINT_FILE).read_bytes() == before
    assert keep({"n": 4, "outcome": "Success"}, "x")
    assert (run.folder / CHECKPOINT_FILE).read_bytes() != before


def test_a_fail_for_good_is_for_good_after_a_resume_too(run: Run) -> None:
    run.cut("RESULT", 0)
    failed = {"n": 1, "outcome": "Fail", "reason": "no way", "permanent": True, "residuals": {}}
    run.append("RESULT", **failed)
    there = standing(run.network, run.records)
    plan = there.route.plan()
    assert isinstance(plan, Plan)
    assert [action.index for action in plan.actions] == [3]
    run.cut("RESULT", 0)
    run.append("RESULT", **failed | {"permanent": False})
    again = standing(run.network, run.records).route.plan()
    assert isinstance(again, Plan)
    assert [action.index for action in again.actions] == [0, 1, 2]


def test_the_result_of_an_action_that_was_not_started_fits_nothing(run: Run) -> None:
    run.cut("RESULT", 1)
    run.append("RESULT", n=1, outcome="Success")
    with pytest.raises(NeedsOperator, match="action 1 is not the one that was started"):
        standing(run.network, run.records)


def test_a_word_on_something_else_settles_nothing(run: Run) -> None:
    """An action that was broken off waits until that very record is acknowledged."""
    run.cut("RESULT", 1)
    start = len(run.records) - 1
    run.append("ACK", record=1, of="RESULT", reason="seen to")
    assert list(waiting(read_run_journal(run.folder))) == [start]
    run.append("ACK", record=start, of="START", reason="seen to")
    assert waiting(read_run_journal(run.folder)) == {}


def test_a_journal_of_another_version_is_not_gone_on_with(run: Run) -> None:
    """D12"""
    run.cut("END", 0)
    header = {key: item for key, item in run.records[0].items() if key not in _OWN}
    other = run.folder.with_name("other")
    other.mkdir()
    with Journal(other / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, header | {"handcart": "0.0.1"})
    with pytest.raises(NeedsOperator, match=r"the run is one of handcart '0\.0\.1'; only"):
        task_of(other)


def test_a_checkpoint_of_another_version_is_refused_in_words(tmp_path: Path) -> None:
    """The names of its parts may have changed, so nothing of it is used."""
    kept: dict[str, Any] = dict.fromkeys(("after", "result", "time_s", "backend", "robot", "model"), None)
    (tmp_path / "checkpoint").write_bytes(pack({"format": "handcart-checkpoint/2", **kept}))
    with pytest.raises(NotAState, match=r"'handcart-checkpoint/2', which another version .* begin a new run"):
        load_checkpoint(tmp_path)


@pytest.mark.parametrize(("word", "cause"), [("F", "unnamed"), ("G", "unnamed"), ("S", "")])
def test_a_resumed_run_ends_with_the_cause_of_its_last_fail(
    new_stand: Callable[[], Stand], tmp_path: Path, word: str, cause: str
) -> None:
    """It is stopped after a Fail or GiveUp, and stopped again before its next action."""
    stand = new_stand()
    network = stand.network("a b x 1", "b z y 1")
    stand.script["x"] = deque([word])
    path = tmp_path / "j"
    with Journal(path) as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
        stand.finish(Coordinator(network, stand.robot, stand.model, journal))
    records = list(read_journal(path).records)
    kept = records[: [record["kind"] for record in records].index("RESULT") + 1]
    if word == "G":
        kept.append({"kind": "ACK", "q": len(kept), "t": 0.0, "record": 3, "of": "RESULT", "reason": "it"})
    run = Coordinator(network, stand.robot, stand.model, standing=standing(network, kept))
    run.request(Request.STOP)
    end = stand.finish(run)
    assert (end.outcome, end.cause, end.fails) == ("Cancelled", cause, int(word != "S"))
