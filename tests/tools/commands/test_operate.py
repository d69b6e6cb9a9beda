"""The operator in command of a run that is alive in another process."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.journal.journal_record import read_journal
from handcart.networks.operator.asking import NotAlive, NotAnswering, ask
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]
PATIENCE_S = 60.0
"""Patience of tests: on a busy machine a run that loads its first motion's libraries answers late."""


class Alive:
    """A running run in a process of its own."""

    def __init__(self, task: Path, runs: Path, *options: str) -> None:
        words = [sys.executable, "-m", "handcart", "run", str(task), "--runs", str(runs), "--json"]
        self.process = subprocess.Popen(
            [*words, *options],
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.folder = runs / f"{task.stem}-0"
        self.wait_for(self._answers)

    def _answers(self) -> bool:
        """Return whether the run answers: its socket exists a moment before that."""
        try:
            return bool(self.say("status")["ok"])
        except (NotAlive, NotAnswering):
            return False

    def wait_for(self, ready: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE_S
        assert self.process.stderr is not None
        while not ready():
            assert self.process.poll() is None, self.process.stderr.read().decode()
            assert time.monotonic() < end
            time.sleep(0.005)

    def say(self, word: str, **more: Any) -> dict[str, Any]:
        return ask(self.folder, {"do": word, **more}, PATIENCE_S)

    def state(self) -> Any:
        return self.say("status")["state"]

    def end(self) -> Any:
        out, _ = self.process.communicate(timeout=PATIENCE_S)
        return json.loads(out.splitlines()[-1])

    def kinds(self) -> list[str]:
        return [record["kind"] for record in read_journal(self.folder / "journal.jsonl").records]


@pytest.fixture
def alive(tour: Path, tmp_path: Path) -> Iterator[Callable[..., Alive]]:
    """Starts a run whose only action waits for permission."""
    tour.write_text(tour.read_text().replace("cost_s: 30,", "cost_s: 30, permit: operator,"))
    started: list[Alive] = []

    def start(*options: str) -> Alive:
        started.append(Alive(tour, tmp_path / "runs", *options))
        return started[-1]

    yield start
    for alive_ in started:
        alive_.process.kill()
        alive_.process.communicate()


@pytest.mark.slow
def test_an_action_waits_for_the_operator_and_says_what_it_wants(alive: Callable[..., Alive]) -> None:
    run = alive()
    run.wait_for(lambda: run.state() == "waiting for permission")
    asked = {"index": 0, "do": "MOVE_TO", "with": {"place": "shelf_3"}, "from": "at_home", "to": "at_shelf"}
    assert run.say("status")["asks"] == {**asked, "ask": 1}
    assert "START" not in run.kinds()
    assert run.say("permit", action=7)["error"].startswith("action 7 doesn't wait for permission")
    assert run.say("permit", action=0)["ok"]
    assert run.end()["outcome"] == "Success"
    assert not (run.folder / "control").exists()


@pytest.mark.slow
def test_refused_it_counts_as_a_fail(alive: Callable[..., Alive]) -> None:
    run = alive()
    for _ in range(3):
        run.wait_for(lambda: run.say("status")["asks"] is not None)
        run.say("refuse")
    end = run.end()
    assert (end["outcome"], end["actions"], end["fails"]) == ("Fail", 0, 3)


@pytest.mark.slow
def test_a_line_that_drops_changes_nothing(alive: Callable[..., Alive]) -> None:
    run = alive()
    run.wait_for(lambda: run.state() == "waiting for permission")
    for _ in range(20):
        run.say("status")  # each hangs up afterwards
    assert run.state() == "waiting for permission"


@pytest.mark.slow
def test_pause_holds_and_continue_goes_on(alive: Callable[..., Alive], handcart: Callable[..., Said]) -> None:
    run = alive()
    run.wait_for(lambda: run.state() == "waiting for permission")
    run.say("pause")
    run.say("permit")
    run.wait_for(lambda: run.state() == "paused while acting")
    times = {run.say("status")["sim_time_s"] for _ in range(6)}  # each answer takes a period
    assert len(times) == 1
    said = handcart("continue", run.folder)
    assert said.status == 0
    assert run.end()["outcome"] == "Success"


@pytest.mark.slow
def test_stop_ends_the_run_where_it_is(alive: Callable[..., Alive], handcart: Callable[..., Said]) -> None:
    run = alive()
    run.wait_for(lambda: run.state() == "waiting for permission")
    assert handcart("stop", run.folder).status == 0
    assert run.end()["outcome"] == "Cancelled"
    assert run.process.returncode == 130


@pytest.mark.slow
def test_interrupts_stop_and_never_start_a_motion(alive: Callable[..., Alive]) -> None:
    """K3: the second one doesn't cut the stop short."""
    run = alive()
    run.wait_for(lambda: run.state() == "waiting for permission")
    run.say("permit")
    run.wait_for(lambda: run.say("status")["sim_time_s"] > 1.0)
    for _ in range(3):
        os.kill(run.process.pid, signal.SIGINT)
    end = run.end()
    assert (end["outcome"], run.process.returncode) == ("Cancelled", 130)
    assert "RESTORE" not in run.kinds()
    assert run.kinds()[-1] == "END"


def test_nobody_is_told_where_no_run_is_alive(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("stop", tmp_path)
    assert said.status == 2
    assert "no run is alive" in said.err


@pytest.mark.slow
def test_words_that_nobody_knows_are_answered(alive: Callable[..., Alive]) -> None:
    run = alive()
    assert "allowed: pause, continue" in run.say("dance")["error"]


@pytest.mark.parametrize("word", ["pause", "continue", "cancel", "restore"])
def test_a_command_names_the_action_that_it_means(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, word: str
) -> None:
    said: list[dict[str, Any]] = []

    def answer(_: Path, message: dict[str, Any]) -> dict[str, Any]:
        said.append(message)
        return {"ok": False, "error": "action 3 is over; allowed: 4, which runs"}

    monkeypatch.setattr("handcart.networks.operator.asking.ask", answer)
    ended = handcart(word, tmp_path, "--number", 3)
    assert said == [{"do": word, "number": 3}]
    assert (ended.status, ended.err.strip()) == (2, "action 3 is over; allowed: 4, which runs")


def test_only_commands_that_move_nothing_take_the_latest_run(
    handcart: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "latest").symlink_to("other-0")
    for word in ("status", "pause", "stop"):
        said = handcart(word)
        assert (said.status, "runs/other-0" in said.err) == (2, True), word
    for word in ("permit", "continue", "cancel", "restore"):
        said = handcart(word)
        assert (said.status, "Missing argument 'run'" in said.err) == (2, True), word
