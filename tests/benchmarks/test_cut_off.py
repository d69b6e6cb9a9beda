"""Benchmarks that are cut off print what they tried until then, and begin nothing further."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff, each_result
from benchmarks.driving import cluttered
from benchmarks.ros2 import tasks
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.runs.run_options import RunOptions

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_row_that_is_cut_off_keeps_its_trials(number: signal.Signals) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    done, before = 0, signal.getsignal(signal.SIGTERM)
    with CutOff() as cut:
        for done in range(20):
            if done == 3:
                os.kill(os.getpid(), number)
                time.sleep(5.0)
    assert cut.came and done == 3
    assert cut.words(done, 20) == " (cut off after 3 of 20)"
    assert cut.status(is_wrong=True) == CUT_OFF_STATUS
    assert signal.getsignal(signal.SIGTERM) is before
    with CutOff() as whole:
        pass
    assert whole.words(20, 20) == ""
    assert (whole.status(is_wrong=True), whole.status(is_wrong=False)) == (1, 0)
    with pytest.raises(ValueError, match="true error"), CutOff():
        raise ValueError("true error")


def test_processes_of_a_loop_that_is_cut_off_are_not_waited_for() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    found, begun = [], time.monotonic()
    with CutOff() as cut:
        for result in each_result(sleep, [(0.0,), (100.0,), (100.0,)], 2):
            found.append(result)
            os.kill(os.getpid(), signal.SIGINT)
    assert cut.came and found == [0.0]
    assert time.monotonic() - begun < 60.0
    assert multiprocessing.active_children() == []


def sleep(duration_s: float) -> float:
    """Wait, and return how long."""
    time.sleep(duration_s)
    return duration_s


def test_an_interrupted_run_ends_the_tasks_and_is_not_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    begun: list[int] = []

    def run(task: str, bench: str, seed: int, heard: Interrupts) -> dict[str, object]:
        begun.append(seed)
        heard.stop_by(lambda: None)
        if seed == 2:
            os.kill(os.getpid(), signal.SIGINT)
        outcome = "GiveUp" if seed == 2 else "Success"
        return {"outcome": outcome, "reason": "", "sim_time_s": 1.0, "metrics": {"untrue": []}}

    monkeypatch.setattr(tasks, "run_once", run)
    monkeypatch.setattr(sys, "argv", ["tasks", "--tasks", "drive_map", "return_book", "--seeds", "9"])
    with pytest.raises(SystemExit) as ended:
        tasks.main()
    assert ended.value.code == CUT_OFF_STATUS
    assert begun == [0, 1, 2]
    printed = capsys.readouterr().out
    assert "Success 2/2  false 0  cut off after 2 of 9 runs" in printed
    assert "GiveUp" not in printed and "return_book" not in printed


def test_an_interrupted_drive_ends_the_worlds_and_is_not_counted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The run itself takes the signal and ends cancelled: the next world began all the same."""
    signal.signal(signal.SIGINT, signal.default_int_handler)

    def run(prepared: Any, run_dir: Path, options: RunOptions) -> Any:
        assert options.interrupts is not None
        options.interrupts.stop_by(lambda: None)
        if prepared.is_cut_off:
            os.kill(os.getpid(), signal.SIGINT)
        return SimpleNamespace(summary={"outcome": "Cancelled", "fails": 0, "reason": "interrupted"})

    monkeypatch.setattr(cluttered, "execute", run)
    monkeypatch.setattr(cluttered, "Judge", lambda prepared: SimpleNamespace(untrue=[]))
    monkeypatch.setattr(cluttered, "Watch", lambda *_: RunObserver())
    begun, ended = [], []
    with CutOff() as cut:
        for seed in range(9):
            begun.append(seed)
            prepared: Any = SimpleNamespace(backend=SimpleNamespace(scene=None), is_cut_off=seed == 2)
            cluttered.run_watched(prepared, tmp_path, cluttered.Trial(seed, 0.2))
            ended.append(seed)
    assert (begun, ended) == ([0, 1, 2], [0, 1])
    assert cut.status(False) == CUT_OFF_STATUS


@pytest.mark.slow
def test_ctrl_c_ends_a_benchmark_of_tasks_with_its_row() -> None:
    words = [sys.executable, "-m", "benchmarks.ros2.tasks", "--tasks", "drive_map", "--benches", "kinematic"]
    with subprocess.Popen(
        [*words, "--seeds", "50"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        try:
            shown = ""
            while "seed 1 ..." not in shown and process.poll() is None:
                shown += process.stderr.read(1)
            time.sleep(1.0)
            process.send_signal(signal.SIGINT)
            row, _ = process.communicate(timeout=60.0)
        finally:
            process.kill()  # a failed test would wait for all runs
    assert process.returncode == CUT_OFF_STATUS
    assert "drive_map" in row and "of 50 runs" in row
