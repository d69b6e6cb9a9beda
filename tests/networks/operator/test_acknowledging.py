"""A person's word, in a run's journal: on the record that was read, once, and on the disk."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.journal.journal import Journal, RunAlive
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.operator.acknowledging import NothingToAcknowledge, acknowledge, cause_of
from handcart.networks.run_files.run_folder import read_run_journal

ACTION = {"index": 0, "do": "MOVE_TO", "from": "a", "to": "b"}
PLAN = ("PLAN", {"situation": "a", "way": [0], "cost": 1.0, "excluded": []})
START = ("START", {"n": 1, "action": {**ACTION, "with": {}}})
GAVE_UP = ("RESULT", {"n": 1, "outcome": "GiveUp", "reason": "it squeaks", "residuals": {}})


def write(folder: Path, *records: tuple[str, Mapping[str, Any]]) -> Path:
    """A real robot's run that is over."""
    folder.mkdir(exist_ok=True)
    with Journal(folder / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {"simulated": False})
        for number, (kind, fields) in enumerate(records, 1):
            journal.append(kind, float(number), fields)
    return folder


def last(folder: Path) -> Mapping[str, Any]:
    record: Mapping[str, Any] = read_journal(folder / "journal.jsonl").records[-1]
    return record


def test_a_giveup_is_acknowledged_once_for_good(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = write(tmp_path / "run", PLAN, START, GAVE_UP)
    synced: list[int] = []
    monkeypatch.setattr(os, "fdatasync", synced.append)
    cause = cause_of(read_run_journal(run), 3)["h"]
    assert acknowledge(run, 3, cause) == "it squeaks"
    said = last(run)
    assert (said["kind"], said["q"], said["t"]) == ("ACK", 4, 3.0)
    assert (said["record"], said["of"], said["cause"], said["reason"]) == (3, "RESULT", cause, "it squeaks")
    assert len(synced) == 1
    with pytest.raises(NothingToAcknowledge, match="record 3 doesn't wait for a person; allowed: none waits"):
        acknowledge(run, 3)


def test_another_record_than_the_one_that_waits_is_refused(tmp_path: Path) -> None:
    run = write(tmp_path / "run", PLAN, START, GAVE_UP)
    for record in (2, 4, -1):
        with pytest.raises(NothingToAcknowledge, match=rf"record {record} doesn't wait .*; allowed: 3$"):
            acknowledge(run, record)
    other = cause_of(read_run_journal(run), 2)["h"]
    with pytest.raises(NothingToAcknowledge, match="record 3 isn't the one that was read"):
        acknowledge(run, 3, other)
    assert last(run)["kind"] == "RESULT"


def test_an_action_that_was_broken_off_waits_by_its_start(tmp_path: Path) -> None:
    run = write(tmp_path / "run", PLAN, START)
    assert acknowledge(run, 2) == "action 1, MOVE_TO from a, was broken off"
    assert last(run)["of"] == "START"


def test_an_action_during_which_the_robot_failed_waits_once(tmp_path: Path) -> None:
    """A fault of the robot leaves START and END open; a person looks at both in one."""
    end = ("END", {"outcome": "GiveUp", "situation": "a", "reason": "axis 2 is lost"})
    run = write(tmp_path / "run", PLAN, START, end)
    with pytest.raises(NothingToAcknowledge, match=r"allowed: 2$"):
        acknowledge(run, 3)
    assert acknowledge(run, 2) == "action 1, MOVE_TO from a, was broken off: axis 2 is lost"
    with pytest.raises(NothingToAcknowledge, match="none waits"):
        acknowledge(run, 3)


def test_a_damaged_record_is_acknowledged_by_the_one_before_it(tmp_path: Path) -> None:
    run = write(tmp_path / "run", PLAN, START, ("RESULT", {"n": 1, "outcome": "Success"}))
    before = last(run)["h"]
    with (run / "journal.jsonl").open("ab") as journal:
        journal.write(b'{"q":4,"p":')
    assert cause_of(read_run_journal(run), 4) == {"kind": "TORN", "h": before}
    assert acknowledge(run, 4, before) == "record 4 is damaged: an action may have begun"
    assert (last(run)["of"], last(run)["cause"], last(run)["q"]) == ("TORN", before, 4)


def test_a_run_that_goes_on_is_not_acknowledged(tmp_path: Path) -> None:
    run = write(tmp_path / "run", PLAN, START, GAVE_UP)
    with Journal.go_on(run / "journal.jsonl", read_journal(run / "journal.jsonl")), pytest.raises(RunAlive):
        acknowledge(run, 3)
