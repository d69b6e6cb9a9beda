"""A run's folder is read with suspicion: nothing in it leads out, blocks, or is too large."""

from __future__ import annotations

import os
import socket
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.run_files.run_folder import NoRun, check_folder, read_file, read_run_journal

HEADER = {"schema": "handcart-journal/2", "task_path": "/t", "simulated": True}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A run's folder with a journal of two records, and something outside of it."""
    made = tmp_path / "run"
    (made / "evidence").mkdir(parents=True)
    (made / "evidence" / "end.npz").write_bytes(b"x")
    (tmp_path / "outside").write_text("keep", encoding="utf-8")
    with Journal(made / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, HEADER)
        journal.append("PLAN", 0.0, {"situation": "a", "way": [0], "cost": 1.0, "excluded": []})
    return made


def test_a_plain_folder_is_read(folder: Path) -> None:
    with socket.socket(socket.AF_UNIX) as control, socket.socket(socket.AF_UNIX) as stop:
        control.bind(os.path.relpath(folder / "control"))
        stop.bind(os.path.relpath(folder / "control.stop"))
        contents = read_run_journal(folder)
    assert [record["kind"] for record in contents.records] == ["RUN", "PLAN"]


@pytest.mark.parametrize(
    "name", ["journal.jsonl", "checkpoint", "summary.new", "evidence/more.npz", "evidence"]
)
@pytest.mark.parametrize("kind", ["link", "dangling", "pipe", "hard link", "socket"])
def test_what_is_no_plain_file_is_refused_and_left_alone(folder: Path, name: str, kind: str) -> None:
    """D14: by link, by pipe, by a second name."""
    path, outside = folder / name, folder.parent / "outside"
    if path.is_dir():
        path = path.rename(folder.parent / "away") and path
    path.unlink(missing_ok=True)
    match kind:
        case "link":
            path.symlink_to(outside)
        case "dangling":
            path.symlink_to(folder / "nothing")
        case "pipe":
            os.mkfifo(path)
        case "hard link":
            os.link(outside, path)
        case "socket":
            with socket.socket(socket.AF_UNIX) as other:
                other.bind(os.path.relpath(path))
    with pytest.raises(NoRun, match=r"in it (is|has)"):
        read_run_journal(folder)
    assert outside.read_text(encoding="utf-8") == "keep"


def test_no_folder(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "none")
    for path, words in (("none", "no such folder"), ("link", "link to nothing"), ("file", "no folder")):
        (tmp_path / "file").touch()
        with pytest.raises(NoRun, match=words):
            check_folder(tmp_path / path)


def test_folders_in_folders_and_a_folder_for_a_file(folder: Path) -> None:
    (folder / "a/b/c/d/e/f").mkdir(parents=True)
    with pytest.raises(NoRun, match="deep"):
        check_folder(folder)


def test_a_folder_in_place_of_the_checkpoint(folder: Path) -> None:
    (folder / "checkpoint").mkdir()
    with pytest.raises(NoRun, match="checkpoint in it is a folder"):
        check_folder(folder)


def test_more_than_a_run_ever_writes(folder: Path) -> None:
    with (folder / "checkpoint").open("wb") as file:
        file.truncate(10**12)
    with pytest.raises(NoRun, match="1000000000000 bytes"):
        read_file(folder, "checkpoint", 1000)


@pytest.mark.parametrize(
    ("kind", "fields", "words"),
    [
        ("START", {"n": 0, "action": {"index": 0, "do": "X", "from": "a", "to": "b"}}, "n: Input"),
        ("START", {"n": 1, "action": {"index": "0", "do": "X", "from": "a", "to": "b"}}, "action.index"),
        ("START", {"n": 1, "action": {}}, "action.index: Field required"),
        ("RESULT", {"n": 1, "outcome": "Fail"}, "reason: Field required"),
        ("RESULT", {"n": 1, "outcome": "Maybe"}, "outcome"),
        ("RESULT", {"n": True, "outcome": "Success"}, "n: Input"),
        ("END", {"outcome": "Success", "situation": 1, "reason": ""}, "situation"),
        ("ACK", {"record": -1, "of": "END", "reason": ""}, "record"),
        ("EPOCH", {"after": "1", "in_doubt": None}, "after"),
        ("RECON", {"situation": None, "at": {"base": [0.0], "base_sigma": [0.0, 0.0]}}, "at.base"),
        ("RUN", HEADER, "begins with RUN, and has one"),
        ("NEW", {}, "no such kind; allowed: RUN, PLAN"),
    ],
)
def test_a_record_that_makes_no_sense_is_told_with_its_place(
    folder: Path, kind: str, fields: dict[str, Any], words: str
) -> None:
    """D15: a forged record with a valid checksum; D12: a kind that only a later version knows."""
    with Journal.go_on(folder / "journal.jsonl", read_run_journal(folder)) as journal:
        journal.append(kind, 1.0, fields)
    with pytest.raises(JournalError, match=rf"record 2 \({kind}\) makes no sense: .*{words}"):
        read_run_journal(folder)
