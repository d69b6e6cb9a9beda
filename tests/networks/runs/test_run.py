"""Executing a run: its folder, its end, and what breaks it off (rows D6, N10)."""

import signal
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import orjson
import pytest

from handcart.backends.robot.robot import Robot
from handcart.files.whole_file import write_whole
from handcart.networks.events.events import Event, RunEnded
from handcart.networks.events.run_end import RunEnd
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalError, read_journal
from handcart.networks.operator.operation import Operation
from handcart.networks.past_runs.action_log import ActionLog
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.run_files.telemetry import load_track
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared, load_model
from handcart.networks.task.task_file import load_task
from tests.journals import timeless_records
from tests.networks.conftest import Stand

TASK = """\
format: handcart-task/1
title: Drive
robot: librarian
parameters: {periods: 30}
start: a
goal: z
situations: {a: {}, b: {}, z: {}}
actions:
  - {do: THINK, from: a, to: b, cost_s: 1, with: {name: x}}
  - {do: DRIVE, from: b, to: z, cost_s: 1, with: {periods: {parameter: periods}}}
"""


class Hears(RunObserver):
    """Notes what it hears of, and has figures of its own."""

    def __init__(self, own: Callable[[], dict[str, Any]]) -> None:
        self.own = own
        self.words: list[str] = []
        self.events: list[Event] = []

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        assert (run_dir / "journal.jsonl").exists()
        self.words.append("begin")

    def period(self, robot: Robot) -> None:
        self.words.append("period")

    def event(self, event: Event) -> None:
        self.events.append(event)

    def end(self) -> None:
        self.words.append("end")

    def figures(self, end: RunEnd) -> dict[str, Any]:
        last = self.events[-1]
        assert isinstance(last, RunEnded)
        assert end is last.end
        self.words.append("figures")
        return self.own()


@pytest.fixture
def prepare(
    tmp_path: Path, new_stand: Callable[[], Stand], primitives: SimpleNamespace
) -> Callable[..., tuple[Stand, Prepared]]:
    def prepared(**settings: str) -> tuple[Stand, Prepared]:
        stand = new_stand()
        path = tmp_path / "task" / "task.yaml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(TASK)
        task = load_task(path, settings, lambda name: getattr(primitives, name))
        return stand, Prepared(task, "two_wheels", stand.backend, stand.robot, stand.model, 7, settings, ())

    return prepared


def test_run_folder(prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path) -> None:
    stand, prepared = prepare(periods="20")
    stand.script["x"] = deque("F")
    folder = tmp_path / "run"
    heard = Hears(lambda: {"x_m": np.float64(stand.robot.pose.x), "at": (1, 2)})
    end, summary = execute(prepared, folder, RunOptions(observers=(heard,)))
    assert end.outcome == "Success"
    assert orjson.loads((folder / "summary.json").read_bytes()) == summary
    assert list(summary) == [
        "outcome", "situation", "reason", "actions", "fails", "replans", "cause", "skipped", "sim_time_s",
        "wall_time_s", "seed", "backend", "run_dir", "metrics",
    ]  # fmt: skip
    assert summary["actions"] == 3
    assert summary["metrics"]["x_m"] == pytest.approx(0.2)
    records = read_journal(folder / "journal.jsonl").records
    assert [record["kind"] for record in records] == (
        ["RUN", "PLAN", *["START", "RESULT"], "PLAN", *["START", "RESULT"] * 2, "END"]
    )
    assert records[0]["settings"] == {"periods": "20"}
    track = load_track(folder / "telemetry.npz")
    assert track.pose.shape == (len(track.time), 3)
    assert set(track.action.tolist()) == {3}
    assert summary["metrics"]["at"] == [1, 2]
    assert type(heard.events[-1]).__name__ == "RunEnded"
    assert heard.words == ["begin", *["period"] * len(track.time), "end", "figures"]


def test_the_log_of_actions_says_what_the_journal_does(
    prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path
) -> None:
    stand, prepared = prepare(periods="5")
    stand.script["x"] = deque("F")
    log = ActionLog()
    execute(prepared, tmp_path / "run", RunOptions(observers=(log,)))
    kept = read_run(tmp_path / "run").actions
    assert [action.outcome for action in log.actions] == ["Fail", "Success", "Success"]
    assert [replace(action, result={}) for action in log.actions] == [
        replace(item, result={}) for item in kept
    ]
    assert [action.reason for action in log.actions] == [item.reason for item in kept]


class Asked(RunObserver):
    """Operator that steps a run from its begin, and permits each action."""

    operation: Operation

    def __init__(self) -> None:
        self.asked: list[str] = []

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        assert self.operation.answer({"do": "step"})["ok"]

    def period(self, robot: Robot) -> None:
        asks = self.operation.status()["asks"]
        if asks is not None:
            self.asked.append(asks["do"])
            assert self.operation.answer({"do": "permit"})["ok"]


def test_a_run_without_permits_of_its_own_can_be_stepped(
    prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    operator = Asked()

    def operation(*parts: Any) -> Operation:
        operator.operation = Operation(*parts)
        return operator.operation

    monkeypatch.setattr("handcart.networks.runs.run.Operation", operation)
    end, _ = execute(prepare(periods="3")[1], tmp_path / "run", RunOptions(observers=(operator,)))
    assert end.outcome == "Success"
    assert operator.asked == ["THINK", "DRIVE"]


def test_same_seed_same_journal(prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path) -> None:
    journals = []
    for name in ("one", "two"):
        _, prepared = prepare()
        execute(prepared, tmp_path / name)
        journals.append(timeless_records(tmp_path / name / "journal.jsonl"))
    assert journals[0] == journals[1]


def test_interrupt_stops_and_holds(prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path) -> None:
    stand, prepared = prepare(periods="2000")
    step = stand.backend.step

    def interrupted() -> None:
        step()
        if 1.0 < stand.robot.time < 1.04:
            signal.raise_signal(signal.SIGINT)

    backend: Any = stand.backend
    backend.step = interrupted
    before = signal.getsignal(signal.SIGINT)
    end = execute(prepared, tmp_path / "run").end
    assert (end.outcome, end.exit_status) == ("Cancelled", 130)
    stop, ended = read_journal(tmp_path / "run" / "journal.jsonl").records[-2:]
    assert (stop["kind"], stop["cause"], ended["kind"]) == ("STOP", "interrupted", "END")
    assert 0.95 < stop["asked_s"] <= stop["sent_s"] < stop["asked_s"] + 3 * 0.05 + 1e-6
    assert ended["t"] - stop["sent_s"] < 0.5
    assert stand.backend.stops
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interrupt_after_the_last_action_changes_nothing(
    prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path
) -> None:
    """K3: the run is over when its END is there; the remaining files are written."""
    _, prepared = prepare()

    def metrics() -> dict[str, Any]:
        for kind in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.raise_signal(kind)
        return {"whole": True}

    end = execute(prepared, tmp_path / "run", RunOptions(observers=(Hears(metrics),))).end
    assert (end.outcome, end.exit_status) == ("Success", 0)
    assert orjson.loads((tmp_path / "run" / "summary.json").read_bytes())["metrics"] == {"whole": True}
    assert (tmp_path / "run" / "telemetry.npz").exists()


def test_disk_full_while_it_runs(
    prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """D6: the robot is stopped; exit status 5."""
    stand, prepared = prepare()
    append = Journal.append

    def full(journal: Journal, kind: str, *rest: Any) -> Any:
        if kind == "RESULT":
            raise JournalError(journal.path, "can't be written: No space left on device")
        return append(journal, kind, *rest)

    monkeypatch.setattr(Journal, "append", full)
    end = execute(prepared, tmp_path / "run").end
    assert (end.outcome, end.exit_status) == ("Error", 5)
    assert "No space left" in end.reason
    assert stand.backend.stops


def test_fault_in_our_own_code(prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path) -> None:
    _, prepared = prepare()

    class Broken(RunObserver):
        def event(self, event: Event) -> None:
            raise ZeroDivisionError("oh")

    end = execute(prepared, tmp_path / "run", RunOptions(observers=(Broken(),))).end
    assert (end.outcome, end.reason) == ("Error", "ZeroDivisionError: oh")
    assert "ZeroDivisionError" in (tmp_path / "run" / "error.txt").read_text()


def test_a_full_disk_takes_no_error_file_either_and_the_run_ends(
    prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """D6: whatever broke the run off, its end is reported."""
    stand, prepared = prepare()

    def full(path: Path, content: str | bytes) -> None:
        if path.name == "error.txt":
            raise OSError(28, "No space left on device", str(path))
        write_whole(path, content)

    class Broken(RunObserver):
        def event(self, event: Event) -> None:
            monkeypatch.setattr("handcart.networks.runs.run.write_whole", full)
            raise ZeroDivisionError("oh")

    end = execute(prepared, tmp_path / "run", RunOptions(observers=(Broken(),))).end
    assert (end.outcome, end.reason) == ("Error", "ZeroDivisionError: oh")
    assert stand.backend.stops
    assert not (tmp_path / "run" / "error.txt").exists()
    assert read_journal(tmp_path / "run" / "journal.jsonl").records[-1]["kind"] == "END"


def test_folder_of_another_run(prepare: Callable[..., tuple[Stand, Prepared]], tmp_path: Path) -> None:
    _, prepared = prepare()
    execute(prepared, tmp_path / "run")
    with pytest.raises(JournalError):
        execute(prepared, tmp_path / "run")


def test_a_task_without_knowledge(prepare: Callable[..., tuple[Stand, Prepared]]) -> None:
    _, prepared = prepare()
    model, warnings = load_model(prepared.task)
    assert model.places == {}
    assert warnings == ()
