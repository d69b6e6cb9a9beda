"""Details of a run on the page: exact values from a journal, and the number of reads."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.files.errors import InputError
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.tools.console import kept_details as module
from handcart.tools.console import run_details as details_module
from handcart.tools.console.kept_details import KeptDetails
from handcart.tools.console.run_details import RunDetails


def cut(ran: Path, folder: Path, kind: bytes, times: int) -> Path:
    """Copy a run up to the `times`-th record of a kind."""
    shutil.copytree(ran, folder)
    lines = (folder / "journal.jsonl").read_bytes().splitlines(keepends=True)
    there = [number for number, line in enumerate(lines) if b'"kind":"' + kind + b'"' in line]
    (folder / "journal.jsonl").write_bytes(b"".join(lines[: there[times - 1] + 1]))
    return folder


def test_a_run_that_is_over_shows_its_end(ran: Path) -> None:
    shown = RunDetails(ran, alive=False).summary(None)
    assert [(action["number"], action["outcome"]) for action in shown["actions"]] == [
        (1, "Success"),
        (2, "Success"),
    ]
    assert shown["situation"] == shown["actions"][-1]["to"]
    assert (shown["reason"], shown["waits"], shown["moved"], shown["view"]) == ("", [], [], None)
    assert shown["resume"] == f"handcart resume {ran}"
    assert shown["view_command"] == f"handcart view {ran}"


def test_a_run_that_was_broken_off_is_where_its_last_action_began(ran: Path, tmp_path: Path) -> None:
    shown = RunDetails(cut(ran, tmp_path / "second", b"START", 2), alive=False).summary(None)
    first, second = shown["actions"]
    assert first["to"] == second["from"] == shown["situation"] != first["from"]
    alone = RunDetails(cut(ran, tmp_path / "first", b"START", 1), alive=False).summary(None)
    assert alone["situation"] == first["from"]
    before = RunDetails(cut(ran, tmp_path / "none", b"RUN", 1), alive=False).summary(None)
    assert (before["situation"], before["actions"], before["reason"]) == ("", [], "")


def test_a_run_that_goes_on_says_itself_where_it_is(ran: Path, tmp_path: Path) -> None:
    folder = cut(ran, tmp_path / "second", b"START", 2)
    assert RunDetails(folder, alive=True).summary("elsewhere")["situation"] == "elsewhere"


def test_pictures_are_listed_by_their_action_and_no_other_files(ran: Path, tmp_path: Path) -> None:
    folder = cut(ran, tmp_path / "second", b"START", 2)
    assert RunDetails(folder, alive=False).summary(None)["pictures"] == []
    (folder / "evidence").mkdir(exist_ok=True)
    for name in ("1000_a.png", "010_b.jpg", "002_c.png", "x_a.jpeg", "003_d.npz"):
        (folder / "evidence" / name).write_bytes(b"")
    shown = RunDetails(folder, alive=False).summary(None)["pictures"]
    assert [(item["action"], item["file"]) for item in shown] == [
        (0, "evidence/x_a.jpeg"),
        (2, "evidence/002_c.png"),
        (10, "evidence/010_b.jpg"),
        (1000, "evidence/1000_a.png"),
    ]


def test_a_change_of_the_world_is_listed_with_its_reason(ran: Path, tmp_path: Path) -> None:
    folder = cut(ran, tmp_path / "second", b"RESULT", 1)
    path = folder / "journal.jsonl"
    with Journal.go_on(path, read_journal(path), "never") as journal:
        index = RunDetails(ran, alive=False).summary(None)["actions"][1]["index"]
        journal.append("RECON", 9.0, {"situation": None, "action": index, "reason": "somebody pushed it"})
    (moved,) = RunDetails(folder, alive=False).summary(None)["moved"]
    assert (moved["reason"], moved["residuals"]) == ("somebody pushed it", {})


def test_what_a_permission_means_is_unknown_in_one_line(ran: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise InputError("the first thing\nthe second")

    monkeypatch.setattr(details_module, "load_task", refused)
    details = RunDetails(ran, alive=True)
    assert details.after("at_home", 0) == {"unknown": "the first thing"}


def test_why_an_action_was_chosen_names_its_probability(ran: Path) -> None:
    details = RunDetails(ran, alive=False)
    first, *others = details.why(1)["why"]
    assert first.startswith("cheapest way to the goal") and "; P(goal) 0." in first
    assert others
    assert details.why(99) == {"unknown": "no action 99 was started"}


class Reader:
    """Counts what is read, and does it at once."""

    def __init__(self) -> None:
        self.count = 0

    async def away(self, work: Callable[[], Any]) -> Any:
        self.count += 1
        return work()


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> Reader:
    class Details:
        def __init__(self, folder: Path, alive: bool) -> None:
            self.folder, self.alive = folder, alive

        def summary(self, situation: str | None) -> dict[str, Any]:
            return {"folder": self.folder.name, "alive": self.alive, "situation": situation}

    monkeypatch.setattr(module, "RunDetails", Details)
    return Reader()


def test_details_are_read_once_until_something_is_new(read: Reader, tmp_path: Path) -> None:
    async def ask_often() -> None:
        kept = KeptDetails()

        async def of(alive: bool = True, situation: str | None = "a") -> Any:
            return orjson.loads(await kept.of(tmp_path, alive, situation, read.away))

        assert await of() == {"folder": tmp_path.name, "alive": True, "situation": "a"}
        await asyncio.gather(of(), of())
        assert read.count == 1
        assert (await of(situation="b"))["situation"] == "b"
        assert (await of(alive=False))["alive"] is False
        assert read.count == 3
        for number, name in enumerate(("journal.jsonl", "evidence", "report.html"), 4):
            (tmp_path / name).write_text("new")
            await of(alive=False)
            await of(alive=False)
            assert read.count == number

    asyncio.run(ask_often())


def test_details_of_thirty_two_runs_are_kept_the_last_asked_for(read: Reader, tmp_path: Path) -> None:
    async def ask_all() -> None:
        kept = KeptDetails()
        for number in range(module.MAX_KEPT_RUNS):
            await kept.of(tmp_path / str(number), False, None, read.away)
        await kept.of(tmp_path / "0", False, None, read.away)
        assert read.count == module.MAX_KEPT_RUNS == 32
        await kept.of(tmp_path / "one more", False, None, read.away)
        await kept.of(tmp_path / "1", False, None, read.away)
        assert read.count == 33
        await kept.of(tmp_path / "0", False, None, read.away)
        assert read.count == 34

    asyncio.run(ask_all())
