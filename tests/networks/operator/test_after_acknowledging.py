"""Situation of a run after a person has acknowledged its GiveUp, or an action that was broken off."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.networks.operator.acknowledging import acknowledge
from handcart.networks.runs.resuming import Past
from handcart.networks.runs.state_check import StateCheck, gone_on
from handcart.primitives.outcomes.residual import Residuals
from handcart.primitives.restoring.snapshot import take_snapshot
from tests.networks.conftest import Stand


def run_of(stand: Stand, network: ActionNetwork, folder: Path) -> Path:
    """Run until the first action gives up, as a real robot's journal."""
    stand.script["direct"] = deque("G")
    path = folder / "journal.jsonl"
    with Journal(path) as journal:
        journal.append("RUN", 0.0, {"network": network.fingerprint(), "simulated": False})
        stand.finish(Coordinator(network, stand.robot, stand.model, journal))
    return path


def broken_off(path: Path) -> int:
    """Write the journal's records again, up to the last START, and return its number."""
    records = read_journal(path).records
    number: int = max(record["q"] for record in records if record["kind"] == "START")
    path.unlink()
    with Journal(path) as journal:
        for record in records[: number + 1]:
            journal.append(record["kind"], record["t"], _own_fields(record))
    return number


def _own_fields(record: Mapping[str, Any]) -> dict[str, Any]:
    return {key: item for key, item in record.items() if key not in {"q", "p", "t", "kind", "h", "wall"}}


@pytest.mark.parametrize("ends", ["GiveUp", "broken off"])
def test_acknowledged_action_stays_in_its_situation(stand: Stand, tmp_path: Path, ends: str) -> None:
    """The person says that all is as it was; `on_fail` describes what only a measured Fail has found out."""
    network = stand.network("a z direct 1 3 blocked", "blocked z detour 1")
    path = run_of(stand, network, tmp_path)
    results = [record["q"] for record in read_journal(path).records if record["kind"] == "RESULT"]
    acknowledge(tmp_path, results[-1] if ends == "GiveUp" else broken_off(path))
    position = standing(network, read_journal(path).records)
    assert (position.route.situation, position.fails) == ("a", 1)
    assert position.route.planner.fails(network.actions[0]) == 1
    with Journal.go_on(path, read_journal(path)) as journal:
        end = stand.finish(Coordinator(network, stand.robot, stand.model, journal, standing=position))
    assert (end.outcome, end.situation) == ("Success", "z")
    starts = [record for record in read_journal(path).records if record["kind"] == "START"]
    assert [record["action"]["from"] for record in starts] == ["a", "a"]


def test_acknowledgement_uses_up_the_last_attempt(stand: Stand, tmp_path: Path) -> None:
    network = stand.network("a z direct 1 1 blocked", "blocked z detour 1")
    path = run_of(stand, network, tmp_path)
    acknowledge(
        tmp_path, [record["q"] for record in read_journal(path).records if record["kind"] == "RESULT"][-1]
    )
    position = standing(network, read_journal(path).records)
    end = stand.finish(Coordinator(network, stand.robot, stand.model, standing=position))
    assert (end.outcome, end.situation) == ("Fail", "a")
    assert "no way left from a" in end.reason


def test_acknowledgement_of_an_older_version_follows_on_fail(stand: Stand, tmp_path: Path) -> None:
    """The later records of such a journal begin there."""
    network = stand.network("a z direct 1 3 blocked", "blocked z detour 1")
    path = run_of(stand, network, tmp_path)
    records = list(read_journal(path).records)
    result = next(record for record in records if record["kind"] == "RESULT")
    ack = {"kind": "ACK", "q": len(records), "t": 0.0, "record": result["q"], "of": "RESULT", "reason": "it"}
    plan = {"kind": "PLAN", "q": len(records) + 1, "t": 0.0, "situation": "blocked", "way": [1]}
    assert standing(network, [*records, ack, plan]).route.situation == "blocked"


def test_broken_off_action_measured_at_its_start_stays(stand: Stand, tmp_path: Path) -> None:
    network = stand.network("a z direct 1 3 blocked", "blocked z detour 1")
    path = run_of(stand, network, tmp_path)
    broken_off(path)
    contents = read_journal(path)
    past = Past(tmp_path, contents, standing(network, contents.records), None, None)
    units, measured = stand.robot.spec.joint_units, take_snapshot(stand.robot, {})
    check = StateCheck(measured, measured, Residuals(), (), True, units)
    resumed = gone_on(past, check, past.last)
    position, closing = resumed.standing, resumed.closing
    assert (position.route.situation, position.fails) == ("a", 1)
    assert position.route.planner.fails(network.actions[0]) == 1
    with Journal.go_on(path, contents) as journal:
        for kind, fields in closing:
            journal.append(kind, 0.0, fields)
        end = stand.finish(Coordinator(network, stand.robot, stand.model, journal, standing=position))
    assert (end.outcome, end.situation) == ("Success", "z")
    again = standing(network, read_journal(path).records)  # the journal says the same
    assert (again.route.situation, again.fails) == ("z", 1)
    starts = [record for record in read_journal(path).records if record["kind"] == "START"]
    assert [record["action"]["from"] for record in starts] == ["a", "a"]


def test_broken_off_action_of_an_older_version_follows_on_fail(stand: Stand, tmp_path: Path) -> None:
    network = stand.network("a z direct 1 3 blocked", "blocked z detour 1")
    path = run_of(stand, network, tmp_path)
    broken_off(path)
    records = list(read_journal(path).records)
    fail = {"n": 1, "outcome": "Fail", "reason": "broken off", "permanent": False, "by": "recon"}
    result = {"kind": "RESULT", "q": len(records), "t": 0.0, **fail}
    assert standing(network, [*records, result]).route.situation == "blocked"
