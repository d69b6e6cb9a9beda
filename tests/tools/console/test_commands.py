"""Commands from the page: permissions and effects; rows U7, U8, U9 and U12 of the faults."""

from __future__ import annotations

import http.client
import json
import shutil
import threading
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import orjson
import pytest

from handcart.networks.journal.journal_record import read_journal
from handcart.tools.console import handlers as handlers_module
from handcart.tools.console import lease as lease_module
from handcart.tools.console.lease import GONE_S, Lease
from tests.conftest import Clock
from tests.tools.console.conftest import LIVE, OVER, LiveRun, Served


@pytest.fixture
def console(live: LiveRun, served: Served) -> Served:
    """Return a console with a running run, after taking the right to command."""
    served.wait_for()
    served.take()
    return served


@pytest.mark.slow
def test_a_command_reaches_its_run_with_who_gave_it(console: Served, live: LiveRun) -> None:
    reply = console.command(do="permit", action=0, ask=1, nonce="n")
    assert (reply.status, reply.json["ok"]) == (200, True)
    assert live.heard == [{"do": "permit", "action": 0, "ask": 1, "nonce": "n", "by": "Ada"}]


@pytest.mark.slow
def test_u8_who_doesn_t_command_only_stops(console: Served, live: LiveRun) -> None:
    other = replace(console, tab="tab-2")
    refused = other.command(do="pause")
    assert (refused.status, refused.json["error"]) == (423, "Ada commands; take the command first")
    assert live.heard == []
    stopped = other.ask("POST", f"/api/runs/{LIVE}/stop", {})
    assert (stopped.status, stopped.json) == (200, {"ok": True})
    end = monotonic() + 10.0
    while not live.stops:
        assert monotonic() < end
        sleep(0.01)
    other.take("Bob")
    assert other.command(do="pause").status == 200
    assert console.command(do="continue").json["error"] == "Bob commands; take the command first"
    assert [message["by"] for message in live.heard] == ["Bob"]


def events(console: Served, count: int) -> list[dict[str, Any]]:
    line = http.client.HTTPConnection("127.0.0.1", console.server.port, timeout=20)
    headers = {"Authorization": f"Bearer {console.token}", "X-Console-Tab": console.tab}
    line.request("GET", "/api/events", headers=headers)
    answer = line.getresponse()
    found = [json.loads(answer.readline()) for _ in range(count)]
    line.close()
    return found


@pytest.mark.slow
def test_u8_everybody_sees_who_commands_and_what_was_said(console: Served) -> None:
    console.command(do="pause")
    (state,) = events(replace(console, tab="tab-2"), 1)
    assert state["lease"] == {"tab": "tab-1", "name": "Ada"}
    run = next(item for item in state["runs"] if item["name"] == LIVE)
    assert [(command["do"], command["by"]) for command in run["commands"]] == [("pause", "Ada")]
    assert run["alive"]
    over = next(item for item in state["runs"] if item["name"] == OVER)
    assert (over["alive"], over["state"]) == (False, "Success")


def test_a_lost_connection_changes_nothing_of_a_run(console: Served, live: LiveRun) -> None:
    for _ in range(3):
        events(console, 1)
    sleep(0.3)
    assert (live.heard, live.stops) == ([], 0)


def test_the_command_is_free_some_time_after_its_page_is_gone() -> None:
    assert GONE_S == 10.0
    clock = Clock()
    lease = Lease(clock)
    lease.connected("a")
    lease.take("a", "Ada")
    lease.gone("a")
    clock.now = GONE_S - 0.1
    assert lease.holds("a")
    lease.connected("a")
    clock.now = 10 * GONE_S
    assert lease.holds("a")
    lease.gone("a")
    clock.now += GONE_S + 0.1
    assert not lease.holds("a")
    assert lease.holder() == {"tab": "", "name": ""}
    lease.take("b", "Bob")
    lease.release("a")
    assert lease.holds("b")
    lease.release("b")
    assert not lease.holds("b")


def test_a_page_that_hangs_up_gives_the_command_back(
    console: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lease_module, "GONE_S", 0.1)
    monkeypatch.setattr(handlers_module, "BEAT_S", 0.05)
    console.take()
    assert events(console, 1)[0]["lease"] == {"tab": "tab-1", "name": "Ada"}
    other, end = replace(console, tab="tab-2"), monotonic() + 10.0
    while other.ask("POST", "/api/lease", {"take": False}).json["lease"]["tab"]:
        assert monotonic() < end
        sleep(0.02)


@pytest.mark.parametrize("name", ["", "   ", None, 7, "x" * 81])
def test_who_commands_has_a_name(served: Served, name: object) -> None:
    assert served.ask("POST", "/api/lease", {"take": True, "name": name}).status == 400
    assert served.ask("POST", "/api/lease", {"take": True, "name": "Ada"}, X_Console_Tab=None).status == 400


def test_break_points_of_all_copies_of_a_situation(console: Served, live: LiveRun) -> None:
    reply = console.command(do="break", places=["at_home", "between"], on=True, nonce="n")
    assert reply.json["breaks"] == ["at_home", "between"]
    assert [message["nonce"] for message in live.heard] == ["n.0", "n.1"]
    assert console.command(do="break", places=[], on=True).status == 409


@pytest.mark.parametrize("message", [{}, {"do": "jump"}, {"do": 7}, {"do": None}])
def test_what_is_no_command_is_refused(console: Served, live: LiveRun, message: dict[str, Any]) -> None:
    assert console.command(**message).status == 400
    assert console.command("nothing", do="pause").status == 404
    assert console.command(OVER, do="pause").status == 409
    assert live.heard == []


def test_what_a_permission_means_for_the_goal(console: Served, ran: Path) -> None:
    """The task's probabilities: at first p 0.85, GiveUp 0.02, 3 attempts, then 0.7; then 0.9, 3 attempts."""
    after = console.ask("GET", f"/api/runs/{LIVE}/after/0").json
    last = 1.0 - 0.1**3
    assert after["succeeded"] == pytest.approx(last)
    assert after["refused"] < after["permitted"] < after["succeeded"]
    assert console.ask("GET", f"/api/runs/{LIVE}/after/2").status == 409
    task = orjson.loads(read_line(ran))["task_path"]
    text = Path(task).read_text(encoding="utf-8")
    try:
        Path(task).write_text(text.replace("cost_s: 30", "cost_s: 31"), encoding="utf-8")
        changed = console.ask("GET", f"/api/runs/{LIVE}/after/0").json
    finally:
        Path(task).write_text(text, encoding="utf-8")
    assert changed == {"unknown": "the task's file has changed since the run began"}


def read_line(folder: Path) -> bytes:
    return (folder / "journal.jsonl").read_bytes().splitlines()[0]


@pytest.fixture
def gave_up(runs: Path, ran: Path) -> Path:
    """Return a run whose journal says that its first action ended in GiveUp."""
    from handcart.networks.journal.journal import Journal

    folder = runs / "walk-2"
    shutil.copytree(ran, folder, ignore=shutil.ignore_patterns("summary.json"))
    lines = (folder / "journal.jsonl").read_bytes().splitlines(keepends=True)
    kept = next(number for number, line in enumerate(lines) if b'"kind":"RESULT"' in line)
    (folder / "journal.jsonl").write_bytes(b"".join(lines[:kept]))
    contents = read_journal(folder / "journal.jsonl")
    with Journal.go_on(folder / "journal.jsonl", contents, "always") as journal:
        fields = {"n": 1, "outcome": "GiveUp", "reason": "somebody stands in the way", "residuals": {}}
        at = orjson.loads(lines[kept]).get("at")
        journal.append("RESULT", 9.0, {**fields, "at": at})
        end = {"outcome": "GiveUp", "situation": "at_home", "reason": "somebody stands in the way", "at": at}
        journal.append("END", 9.0, end)
    return folder


def test_u12_an_acknowledgement_quotes_the_cause_that_was_read(served: Served, gave_up: Path) -> None:
    served.wait_for("/api/runs/walk-2")
    (waits,) = served.ask("GET", "/api/runs/walk-2").json["waits"]
    assert waits["reason"] == "somebody stands in the way"
    right = {"record": waits["record"], "cause": waits["cause"]}
    path = "/api/runs/walk-2/acknowledge"
    assert served.ask("POST", path, right).status == 423
    served.take()
    for wrong in ({}, {"record": waits["record"]}, {**right, "record": True}, {**right, "cause": ""}):
        assert served.ask("POST", path, wrong).status == 400
    for wrong in ({**right, "cause": "0" * 64}, {**right, "record": waits["record"] + 1}):
        assert served.ask("POST", path, wrong).status == 409
    assert served.ask("GET", "/api/runs/walk-2").json["waits"] == [waits]
    assert served.ask("POST", path, right).json == {"ok": True, "reason": waits["reason"]}
    assert served.ask("GET", "/api/runs/walk-2").json["waits"] == []
    assert read_journal(gave_up / "journal.jsonl").records[-1]["kind"] == "ACK"


def test_u13_a_robot_that_was_moved_by_hand_is_shown_before_and_after(served: Served, live: LiveRun) -> None:
    from handcart.networks.journal.journal import Journal

    path = live.folder / "journal.jsonl"
    with Journal.go_on(path, read_journal(path), "always") as journal:
        found = {"situation": None, "expected": None, "residuals": {"base_mm": 31.5}, "unknown": ["the tray"]}
        journal.append("RECON", 9.0, found)
    served.wait_for()
    (moved,) = served.ask("GET", f"/api/runs/{LIVE}").json["moved"]
    assert (moved["residuals"], moved["unknown"]) == ({"base_mm": 31.5}, ["the tray"])


@pytest.mark.slow
def test_u9_stop_goes_through_while_everybody_asks(console: Served, live: LiveRun) -> None:
    """50 that listen and ask for all there is; how long it takes: `python -m benchmarks.console`."""
    over = threading.Event()

    def bother(number: int) -> None:
        mine = replace(console, tab=f"other-{number}")
        while not over.is_set():
            events(mine, 1)
            mine.ask("GET", f"/api/runs/{OVER}")

    others = [threading.Thread(target=bother, args=(number,)) for number in range(50)]
    for other in others:
        other.start()
    try:
        for _ in range(20):
            assert console.ask("POST", f"/api/runs/{LIVE}/stop", {}).status == 200
    finally:
        over.set()
        for other in others:
            other.join()
    assert live.stops >= 1
