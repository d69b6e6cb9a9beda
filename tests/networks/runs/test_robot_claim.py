"""Claims of a real robot, and runs that wait for a person and block it (rows N13, K11)."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.journal.retracing import NeedsOperator
from handcart.networks.runs.robot_claim import NoClaimFolder, RobotBusy, RobotClaim, claimed, claims_folder


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
        with RobotClaim(robot("can1 cart"), tmp_path) as other:
            assert other.path == tmp_path / "can-can1_cart"
    with RobotClaim(robot(), tmp_path) as again:
        assert (again.path, again.path.read_text()) == (tmp_path / "can-can0_cart", "")


def test_a_claim_that_is_refused_names_the_run_and_lets_go(tmp_path: Path) -> None:
    with RobotClaim(robot(), tmp_path) as claim:
        claim.begin(tmp_path / "run")
        before = len(os.listdir("/proc/self/fd"))
        for _ in range(3):
            with pytest.raises(RobotBusy, match=f"in another run: {tmp_path / 'run'}; allowed: one at a"):
                RobotClaim(robot(), tmp_path)
        assert len(os.listdir("/proc/self/fd")) == before
    claim.close()  # a second time


@pytest.mark.parametrize("state", ["a file", "a link", "a folder for a file"])
def test_a_state_folder_that_can_not_be_used_is_reported(tmp_path: Path, state: str) -> None:
    folder = tmp_path / "state"
    if state == "a file":
        folder.write_text("")
    else:
        folder.mkdir()
        own = folder / "can-can0_cart"
        own.symlink_to(tmp_path / "elsewhere") if state == "a link" else own.mkdir()
    with pytest.raises(NoClaimFolder, match=r"can-can0_cart can't be opened: .*; allowed: a folder of yours"):
        RobotClaim(robot(), folder)
    assert not (tmp_path / "elsewhere").exists()


def test_a_file_of_a_robot_is_its_owners_alone(tmp_path: Path) -> None:
    folder = tmp_path / "made" / "state"
    with RobotClaim(robot(), folder) as claim:
        assert (folder.stat().st_mode & 0o777, claim.path.stat().st_mode & 0o777) == (0o700, 0o600)


def test_a_disk_that_takes_no_name_lets_nothing_move(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: int) -> None:
        raise OSError(28, "No space left on device")

    with RobotClaim(robot(), tmp_path) as claim:
        monkeypatch.setattr(os, "fsync", fails)
        with pytest.raises(JournalError, match="can't be written: No space left"):
            claim.begin(tmp_path / "run")


def test_a_run_whose_journal_is_gone_is_not_over(tmp_path: Path) -> None:
    run, state = run_of(tmp_path / "one", over=False), tmp_path / "state"
    begun(state, run)
    (run / "journal.jsonl").unlink()
    with pytest.raises(NeedsOperator, match=f"its journal is gone; if it may move: rm {state / 'can-can0'}"):
        RobotClaim(robot(), state)
    with RobotClaim(robot(), state, run) as claim:
        assert claim.path.read_text() == f"{run}\n"


def test_a_simulated_robot_is_nobodys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    one = robot()
    with claimed(one) as claim, pytest.raises(RobotBusy):
        assert claim is not None
        assert claim.path == tmp_path / "handcart" / "robots" / "can-can0_cart"
        claimed(one)
    one.simulated = True
    with claimed(one) as first, claimed(one) as second:
        assert first is second is None
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert claims_folder() == tmp_path / ".local" / "state" / "handcart" / "robots"


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
    with RobotClaim(robot(), state, run) as claim:
        assert claim.path.read_text() == f"{run}\n"
    assert claim.path.read_text() == f"{run}\n"  # nothing began, so it is as it was


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
    run = tmp_path / "never begun"
    run.mkdir()
    begun(tmp_path, run)
    with RobotClaim(robot(), tmp_path) as claim:
        assert claim.path.read_text() == ""


def test_a_run_that_was_deleted_under_way_does_not_free_the_robot(tmp_path: Path) -> None:
    run, state = run_of(tmp_path / "one", over=False), tmp_path / "state"
    with RobotClaim(robot(), state) as claim:
        claim.begin(run)
        shutil.rmtree(run)
    with pytest.raises(NeedsOperator, match="its journal is gone; if it may move: rm "):
        RobotClaim(robot(), state)
