"""What the process, its machine and its installation do to a run on simulated drives."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from backends.can.can_backend import CanBackend
from networks.robot_claim import RobotClaim, state_folder

ON_CAN = ("--robot", "cart", "--backend", "can")
LATEST_S = 120.0


def python(*lines: str, **options: Any) -> subprocess.Popen[bytes]:
    """A process that runs these lines."""
    return subprocess.Popen([sys.executable, "-c", "\n".join(lines)], **options)


def test_memory_that_runs_out_stops_the_robot(
    handcart: Callable[..., Any], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K5: what the operating system's killer does is K1; a MemoryError stops, and is told."""
    stops, step, count = [], CanBackend.step, iter(range(10**6))

    def fails(self: CanBackend) -> None:
        if next(count) == 20:
            raise MemoryError
        step(self)

    monkeypatch.setattr(CanBackend, "step", fails)
    monkeypatch.setattr(CanBackend, "stop", lambda self: stops.append(self._periods))
    said = handcart("run", tour, *ON_CAN, "--runs", tmp_path / "runs", "--json")
    assert said.status == 5
    assert json.loads(said.out.splitlines()[-1])["reason"].startswith("MemoryError")
    assert stops[-1] == 20


def test_files_that_run_out_start_nothing(tour: Path, tmp_path: Path) -> None:
    """K10: the limit of open files."""
    process = python(
        "import resource",
        "import evaluation.running, evaluation.overview, backends.can.can_backend",
        "import backends.kinematic.kinematic_backend, tools.run_task, tools.progress",
        "from tools.handcart import main",
        "resource.setrlimit(resource.RLIMIT_NOFILE, (5, 5))",
        f"main(['run', {str(tour)!r}, *{ON_CAN!r}, '--runs', {str(tmp_path / 'runs')!r}])",
        stderr=subprocess.PIPE,
    )
    _, said = process.communicate(timeout=LATEST_S)
    assert process.returncode == 5
    assert b"Too many open files" in said
    journals = list((tmp_path / "runs").rglob("journal.jsonl"))
    assert all(b'"kind":"START"' not in each.read_bytes() for each in journals)


def test_a_lock_goes_with_its_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """K12: no process IDs are kept, so none can be taken for another process's."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    holder = python(
        "import time",
        "from backends.can.can_backend import CanBackend",
        "from networks.robot_claim import RobotClaim, state_folder",
        "class Robot:",
        "    name, address = 'can', 'virtual cart'",
        "claim = RobotClaim(Robot(), state_folder())",
        "print('held', flush=True)",
        "time.sleep(600)",
        stdout=subprocess.PIPE,
    )
    assert holder.stdout is not None
    assert holder.stdout.readline() == b"held\n"
    holder.kill()
    holder.wait()
    holder.stdout.close()

    class Robot:
        name, address = "can", "virtual cart"

    RobotClaim(Robot(), state_folder()).close()  # type: ignore[arg-type]


def test_a_library_that_is_missing_is_named(
    handcart: Callable[..., Any], tour: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K13: before anything moves, with how to install it."""
    monkeypatch.delitem(sys.modules, "backends.can.can_backend")
    monkeypatch.setitem(sys.modules, "can", None)
    said = handcart("run", tour, *ON_CAN)
    assert said.status == 2
    assert "the backend 'can' needs the package 'can'" in said.err
    assert "pip install" in said.err


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_nobody_listens_and_it_stops_all_the_same(tour: Path, tmp_path: Path, stream: str) -> None:
    """K14: a pipe that is closed at its other end doesn't stop the stop."""
    reading, writing = os.pipe()
    process = python(
        "from tools.handcart import main",
        f"main(['run', {str(tour)!r}, *{ON_CAN!r}, '--runs', {str(tmp_path / 'runs')!r}])",
        **{"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, stream: writing},
    )
    os.close(writing)
    end = time.monotonic() + LATEST_S
    while not any(b'"kind":"START"' in each.read_bytes() for each in (tmp_path / "runs").rglob("*.jsonl")):
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.02)
    os.close(reading)
    process.send_signal(signal.SIGINT)
    process.wait(timeout=LATEST_S)
    (told,) = (tmp_path / "runs").rglob("journal.jsonl")
    last = json.loads(told.read_bytes().splitlines()[-1])
    assert last["kind"] == "END"
    assert last["outcome"] in ("Cancelled", "Error")
