"""Who may have a real robot, and what a run that a person has to see to keeps from others (rows N13, K11)."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.journal.retracing import NeedsOperator
from handcart.networks.runs.robot_claim import RobotBusy, RobotClaim


def robot(address: str = "can0 cart") -> Any:
    return SimpleNamespace(name="can", address=address, simulated=False)


def run_of(folder: Path, *, over: bool) -> Path:
    """A real robot's run that came to its end, or broke off in the middle of an action."""
    folder.mkdir()
    with Journal(folder / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {"simulated": False})
        action = {"index": 0, "do": "MOVE_TO", "from": "a", "to": "b"}
        journal.append("START", 1.0, {"n": 1, "action": action})
        if over:
            journal.append("RESULT", 2.0, {"n": 1, "outcome": "Success"})
            journal.append("END", 2.0, {"outcome": "Success", "situation": "b", "reason": ""})
    return folder


def begun(state: Path, run: Path) -> None:
    """A process had the robot in that run, and let go of it."""
    with RobotClaim(robot(), state) as claim:
        claim.begin(run)


def test_one_process_at_a_time_has_a_robot(tmp_path: Path) -> None:
    with RobotClaim(robot(), tmp_path):
        with pytest.raises(RobotBusy, match="in another run: not named yet; allowed: one at a time"):
            RobotClaim(robot(), tmp_path)
        RobotClaim(robot("can1 cart"), tmp_path).close()  # another robot
    RobotClaim(robot(), tmp_path).close()


def test_the_run_is_named_for_good_before_anything_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = []
    with RobotClaim(robot(), tmp_path) as claim:
        monkeypatch.setattr(os, "fsync", lambda _: kept.append(claim.path.read_text()))
        claim.begin(tmp_path / "a longer name")
        claim.begin(tmp_path / "run")
    assert kept == [f"{tmp_path / 'a longer name'}\n", f"{tmp_path / 'run'}\n"]


def test_after_a_run_that_is_over_the_next_may_begin(tmp_path: Path) -> None:
    begun(tmp_path / "state", run_of(tmp_path / "one", over=True))
    with RobotClaim(robot(), tmp_path / "state") as claim:
        assert claim.path.read_text() == ""


def test_after_one_that_waits_only_that_one_goes_on(tmp_path: Path) -> None:
    run, state = run_of(tmp_path / "one", over=False), tmp_path / "state"
    begun(state, run)
    other = run_of(tmp_path / "other", over=True)
    for own in (None, other):
        with pytest.raises(NeedsOperator, match=r"action 1, MOVE_TO from a, was broken off; .* handcart ack"):
            RobotClaim(robot(), state, own)
    RobotClaim(robot(), state, run).close()


def test_what_can_not_be_read_may_wait(tmp_path: Path) -> None:
    run, state = run_of(tmp_path / "one", over=True), tmp_path / "state"
    journal = run / "journal.jsonl"
    content = bytearray(journal.read_bytes())
    content[len(content) // 2] ^= 4
    journal.write_bytes(content)
    begun(state, run)
    assert (state / "can-can0_cart").read_text() == f"{run}\n"
    with pytest.raises(JournalError, match="isn't what was written"):
        RobotClaim(robot(), state)


def test_where_no_journal_was_made_nothing_has_moved(tmp_path: Path) -> None:
    begun(tmp_path, tmp_path / "never begun")
    RobotClaim(robot(), tmp_path).close()
