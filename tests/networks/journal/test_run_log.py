"""Records of actions in a run's journal, and the order in which observers are notified."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.networks.events.events import Ended, Event, Restoring, Started
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.journal.journal import Journal, plain_json
from handcart.networks.journal.journal_record import JournalError, read_journal
from handcart.networks.journal.measured import measure, measured_fields, snapshot_of
from handcart.networks.journal.retracing import NeedsOperator, standing
from handcart.networks.journal.run_log import RunLog, outcome_record
from handcart.primitives.books.book_causes import JAMMED
from handcart.primitives.outcomes.cause import Cause
from handcart.primitives.outcomes.discrepancy import Measured
from handcart.primitives.outcomes.outcome import GiveUp, Success, fail_if_restored
from handcart.primitives.outcomes.residual import read_residuals
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.robotics.geometry.pose2 import Pose2
from tests.networks.conftest import Stand

AT = Snapshot(
    pose=Pose2(1.0, 2.0, 0.5),
    pose_sigma=(0.01, math.inf),
    joints=np.array([0.1, 0.2]),
    joint_command=np.array([0.3, 0.4]),
    gripper_command=0.05,
    gripper_width=0.04,
    holding=True,
    seen={},
)
FIELDS = {
    "base": [1.0, 2.0, 0.5],
    "base_sigma": [0.01, math.inf],
    "joints": [0.1, 0.2],
    "joint_command": [0.3, 0.4],
    "grip": 0.04,
    "grip_command": 0.05,
    "holding": True,
}


def test_a_snapshot_comes_back_from_the_journal_as_it_was() -> None:
    assert measured_fields(AT) == FIELDS
    again = snapshot_of(plain_json(measured_fields(AT)))
    assert (again.pose, again.pose_sigma) == (AT.pose, AT.pose_sigma)
    assert (again.joints.tolist(), again.joint_command.tolist()) == ([0.1, 0.2], [0.3, 0.4])
    assert (again.gripper_width, again.gripper_command, again.holding) == (0.04, 0.05, True)
    assert snapshot_of({"base": [0.0, 0.0, 0.0], "base_sigma": [None, 0.1]}).pose_sigma == (math.inf, 0.1)


@pytest.mark.parametrize(
    ("change", "left"),
    [
        ({"joints": np.empty(0), "joint_command": np.empty(0)}, {"grip", "grip_command", "holding"}),
        ({"gripper_width": 0.0}, {"joints", "joint_command", "grip", "grip_command", "holding"}),
        ({"gripper_command": 0.0}, {"joints", "joint_command", "grip", "grip_command", "holding"}),
        ({"gripper_command": 0.0, "gripper_width": 0.0}, {"joints", "joint_command"}),
    ],
)
def test_what_a_robot_lacks_is_not_journaled(change: dict[str, Any], left: set[str]) -> None:
    fields = measured_fields(replace(AT, **change))
    assert fields.keys() - {"base", "base_sigma"} == left
    again = snapshot_of({key: fields[key] for key in ("base", "base_sigma")})
    assert (again.joints.size, again.gripper_width, again.gripper_command, again.holding) == (0, 0, 0, False)


def test_a_robot_that_can_not_be_read_is_not_measured() -> None:
    robot: Any = SimpleNamespace()
    assert measure(robot) is None


@pytest.mark.parametrize(
    ("outcome", "record"),
    [
        (Success(), {"n": 3, "outcome": "Success"}),
        (Success({"mm": 1.0}), {"n": 3, "outcome": "Success", "evidence": {"mm": 1.0}}),
        (
            fail_if_restored("x", True, read_residuals({"held": 0.0}, {"held": 0.0})),
            {"n": 3, "outcome": "Fail", "reason": "x", "permanent": True, "residuals": {"held": 0.0}},
        ),
        (
            GiveUp("x", read_residuals({"held": 1.0}, {})),
            {"n": 3, "outcome": "GiveUp", "reason": "x", "residuals": {"held": 1.0}},
        ),
    ],
)
def test_an_outcome_is_told_whole(outcome: Any, record: Mapping[str, Any]) -> None:
    assert outcome_record(3, outcome) == record


def result_of(stand: Stand, folder: Path, outcome: Any, **evidence: Any) -> Mapping[str, Any]:
    """The journal's RESULT of an action that left that evidence, without what every record has."""
    primitive: Any = stand.Think(name="x")
    for name, value in evidence.items():
        setattr(primitive.evidence, name, value)
    with Journal(folder / "j") as journal:
        RunLog(stand.robot, stand.model, journal, ()).result(primitive, outcome)
    (record,) = read_journal(folder / "j").records
    own = ("q", "p", "t", "kind", "h", "wall", "n", "outcome", "reason", "residuals")
    return {key: value for key, value in record.items() if key not in own}


CAUSES = [
    Cause("it resists", "watch", ("A.motion",), Measured("Arm", "force", 8.0, 7.0, "N"), "", False, JAMMED),
    Cause("no", "restore", (), None, "ValueError", True),
]


def test_why_an_action_did_not_succeed_is_told_whole(stand: Stand, tmp_path: Path) -> None:
    evidence = {"causes": CAUSES, "decisive": "front", "facts": {"mm": 1.0}}
    force = {"sensor": "Arm", "what": "force", "value": 8.0, "limit": 7.0, "unit": "N"}
    outcome = GiveUp("x", read_residuals({"base_mm": 41.0}, {"base_mm": 40.0}))
    assert result_of(stand, tmp_path, outcome, **evidence) == {
        "cause": [
            {
                "reason": "it resists",
                "kind": "jammed",
                "check": "watch",
                "calls": ["A.motion"],
                "measured": force,
            },
            {
                "reason": "no",
                "kind": "unnamed",
                "check": "restore",
                "calls": [],
                "fault": "ValueError",
                "restoring": True,
            },
        ],
        "tolerance": {"base_mm": 40.0},
        "picture": "front",
        "evidence": {"mm": 1.0},
    }


@pytest.mark.parametrize("outcome", [GiveUp("x"), Success()])
def test_what_an_action_left_nothing_of_is_not_told(stand: Stand, tmp_path: Path, outcome: Any) -> None:
    assert result_of(stand, tmp_path, outcome) == {}


def test_a_success_has_no_cause_whatever_was_noted_on_the_way(stand: Stand, tmp_path: Path) -> None:
    evidence = {"causes": CAUSES, "decisive": "front"}
    assert result_of(stand, tmp_path, Success(), **evidence) == {}


def test_a_result_is_kept_before_it_is_journaled_and_told_after(stand: Stand, tmp_path: Path) -> None:
    """The checkpoint's name is outside the chain; observers are notified when the result is safe."""
    events: list[Event] = []
    kept: list[tuple[Mapping[str, Any], str, int]] = []
    action = stand.network("a z go 1").actions[0]
    primitive = stand.Think(name="x")
    with Journal(tmp_path / "j") as journal:

        def keep(result: Mapping[str, Any], after: str) -> str:
            kept.append((result, after, len(read_journal(journal.path).records)))
            return "digest"

        log = RunLog(stand.robot, stand.model, journal, [events.append], keep=keep)
        log.start(action, primitive, 2)
        assert log.open
        log.restoring(action, "enough")
        last = journal.last
        log.result(primitive, Success(), AT)
        assert log.open
        assert [type(event) for event in events] == [Started, Restoring]
        log.result_kept(action, primitive, Success())
    start, restore, result = read_journal(tmp_path / "j").records
    assert not log.open
    assert (start["n"], start["action"]["index"], "at" in start) == (1, 0, False)
    assert (restore["n"], restore["reason"]) == (1, "enough")
    assert kept == [({"n": 1, "outcome": "Success", "at": FIELDS}, last, 2)]
    assert result["wall"]["checkpoint"] == "digest"
    assert isinstance(events[0], Started)
    assert isinstance(events[2], Ended)
    assert (events[0].number, events[0].fails, events[2].number) == (1, 2, 1)


def test_no_action_starts_once_the_journal_was_replaced(stand: Stand, tmp_path: Path) -> None:
    """The record of the result before it need not notice."""
    path, primitive = tmp_path / "j", stand.Think(name="x")
    action = Action("a", "z", Binding.of(primitive), index=0)
    with Journal(path) as journal:
        log = RunLog(stand.robot, stand.model, journal, ())
        log.start(action, primitive, 0)
        path.rename(tmp_path / "away")
        path.write_bytes(b"")
        log.result(primitive, Success())
        with pytest.raises(JournalError, match="replaced"):
            log.start(action, primitive, 0)


def test_a_plan_that_a_fault_prevents_is_told_with_its_trace(stand: Stand, tmp_path: Path) -> None:
    with Journal(tmp_path / "j") as journal:
        log = RunLog(stand.robot, stand.model, journal, ())
        try:
            raise ValueError("the planner is broken")
        except ValueError as error:
            log.not_planned("a", error)
    record = read_journal(tmp_path / "j").records[-1]
    assert (record["kind"], record["situation"]) == ("PLAN", "a")
    assert "ValueError: the planner is broken" in record["error"]


def test_an_action_that_binds_late_is_told_anew_each_time(stand: Stand, tmp_path: Path) -> None:
    late = Binding(stand.Think, {"name": "x"}, {"text": "cup.name"})
    for binding, texts in ((late, ["one", "two"]), (Binding.of(stand.Think(name="x")), ["one", "one"])):
        action = Action("a", "z", binding, index=0)
        path = tmp_path / f"{texts[1]}"
        with Journal(path) as journal:
            log = RunLog(stand.robot, stand.model, journal, ())
            for text in ("one", "two"):
                log.start(action, stand.Think(name="x", text=text), 0)
        assert [record["action"]["with"]["text"] for record in read_journal(path).records] == texts


def followed(network: ActionNetwork, *records: Mapping[str, Any]) -> Any:
    header = {"kind": "RUN", "q": 0, "network": network.fingerprint()}
    return standing(network, [header, *({"q": q, **record} for q, record in enumerate(records, 1))])


def journal_of(network: ActionNetwork) -> tuple[dict[str, Any], ...]:
    action = network.actions[0]
    words = {"index": 0, "do": action.do, "from": "a", "to": "b"}
    return (
        {"kind": "PLAN", "situation": "a"},
        {"kind": "START", "n": 1, "action": words, "at": FIELDS},
        {"kind": "RESULT", "n": 1, "outcome": "Success", "at": {**FIELDS, "base": [9.0, 9.0, 0.0]}},
    )


def test_a_journal_leads_to_where_its_run_stands(stand: Stand) -> None:
    network = stand.network("a b one 1", "b z two 1", "a z other 9")
    plan, start, result = journal_of(network)
    begun = followed(network, plan, start)
    assert (begun.started, begun.done, begun.in_doubt["n"], begun.plans) == (1, 0, 1, 1)
    assert (begun.at.pose.x, list(begun.seen)) == (1.0, ["a"])
    done = followed(network, plan, start, result)
    assert (done.started, done.done, done.left, done.in_doubt) == (1, 1, "a", None)
    assert (done.at.pose.x, list(done.seen), done.route.situation) == (9.0, ["a", "b"], "b")
    assert [done.seen[name].pose.x for name in "ab"] == [1.0, 9.0]
    other = {"kind": "NOT_STARTED", "action": 1, "reason": "refused"}
    refused = followed(network, plan, start, result, other)
    assert (refused.fails, refused.done, refused.route.situation) == (1, 1, "b")
    elsewhere = {"kind": "RECON", "action": 1, "reason": "pushed", "situation": "a", "at": FIELDS}
    moved = followed(network, plan, start, result, elsewhere)
    assert (moved.fails, moved.route.situation, moved.at.pose.x) == (1, "a", 1.0)
    assert list(moved.seen) == ["b", "a"]
    end = {"kind": "END", "outcome": "GiveUp", "situation": "b", "reason": "x"}
    given_up = followed(network, plan, start, result, end)
    assert given_up.gave_up is given_up.over
    assert given_up.over["outcome"] == "GiveUp"
    failed = followed(network, plan, start, result, {**end, "outcome": "Fail"})
    assert (failed.gave_up, failed.over["outcome"]) == (None, "Fail")
    state = followed(
        network, plan, start, result, end, {"kind": "ACK", "record": 4, "of": "END", "reason": ""}
    )
    assert (state.gave_up, state.over, state.fails) == (None, None, 0)
    looked_at = {"kind": "ACK", "record": 3, "of": "END", "reason": ""}
    still = followed(network, plan, start, {**end, "situation": "a"}, looked_at)
    assert (still.gave_up, still.over, still.in_doubt["n"], still.fails) == (None, None, 1, 0)
    epoch = followed(network, plan, start, {"kind": "EPOCH"})
    assert (epoch.in_doubt, epoch.over, epoch.fails) == (None, None, 0)


@pytest.mark.parametrize(
    ("number", "change", "words"),
    [
        (0, {"situation": "b"}, r"record 1 \(PLAN\) .*: the run is in situation a"),
        (0, {"situation": "nowhere"}, "unknown situation 'nowhere'"),
        (1, {"n": 2}, "action 1 was next"),
        (1, {"action": {"index": 1}}, "another action was next"),
        (2, {"n": 2}, "action 2 is not the one that was started"),
        (2, {"outcome": "Fail"}, "'reason'"),
    ],
)
def test_a_record_that_does_not_follow_is_for_a_person(
    stand: Stand, number: int, change: dict[str, Any], words: str
) -> None:
    network = stand.network("a b one 1", "b z two 1", "a z other 9")
    records = list(journal_of(network))
    records[number] = records[number] | change
    with pytest.raises(NeedsOperator, match=words):
        followed(network, *records)


def test_a_journal_of_another_network_is_for_a_person(stand: Stand) -> None:
    network = stand.network("a z one 1")
    for records in ([], [{"kind": "RUN", "q": 0, "network": "x"}], [{"kind": "RUN", "q": 0}]):
        with pytest.raises(NeedsOperator, match="its network is another one"):
            standing(network, records)
    assert ActionNetwork.build([Situation("a")], [], "a", "a").fingerprint() != network.fingerprint()
