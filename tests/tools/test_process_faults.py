"""Faults of the process, its machine and its installation during a run on simulated drives."""

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

from handcart.backends.can.can_backend import CanBackend
from handcart.networks.runs.robot_claim import RobotClaim, claims_folder
from handcart.tools.command_line import OWN_COMMANDS
from tests.tools.conftest import Said

ON_CAN = ("--robot", "cart", "--backend", "can")
LATEST_S = 120.0


def python(*lines: str, **options: Any) -> subprocess.Popen[bytes]:
    """A process that runs these lines."""
    return subprocess.Popen([sys.executable, "-c", "\n".join(lines)], **options)


@pytest.mark.slow
def test_memory_that_runs_out_stops_the_robot(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K5: a kill by the operating system is K1; a MemoryError stops the robot, and is reported."""
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


@pytest.mark.slow
def test_files_that_run_out_start_nothing(tour: Path, tmp_path: Path) -> None:
    """K10: the limit of open files."""
    process = python(
        "import resource",
        "from handcart.evaluation.trials import overview, running",
        "from handcart.backends.can import can_backend",
        "from handcart.backends.kinematic import kinematic_backend",
        "from handcart.tools import run_task",
        "from handcart.tools.terminal import progress",
        "from handcart.tools.main import main",
        "resource.setrlimit(resource.RLIMIT_NOFILE, (5, 5))",
        f"main(['run', {str(tour)!r}, *{ON_CAN!r}, '--runs', {str(tmp_path / 'runs')!r}])",
        stderr=subprocess.PIPE,
    )
    _, said = process.communicate(timeout=LATEST_S)
    assert process.returncode == 5
    assert b"Too many open files" in said
    journals = list((tmp_path / "runs").rglob("journal.jsonl"))
    assert all(b'"kind":"START"' not in journal.read_bytes() for journal in journals)


@pytest.mark.slow
def test_a_lock_goes_with_its_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """K12: no process IDs are kept, so none can be confused with another process's."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    holder = python(
        "import time",
        "from handcart.backends.can.can_backend import CanBackend",
        "from handcart.networks.runs.robot_claim import RobotClaim, claims_folder",
        "class Robot:",
        "    name, address = 'can', 'virtual cart'",
        "claim = RobotClaim(Robot(), claims_folder())",
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

    RobotClaim(Robot(), claims_folder()).close()  # type: ignore[arg-type]


def test_a_library_that_is_missing_is_named(
    handcart: Callable[..., Said], tour: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K13: before anything moves, with how to install it."""
    monkeypatch.delitem(sys.modules, "handcart.backends.can.can_backend")
    monkeypatch.setitem(sys.modules, "can", None)
    said = handcart("run", tour, *ON_CAN)
    assert said.status == 2
    assert "the backend 'can' needs the package 'can'" in said.err
    assert "pip install" in said.err


def say(*words: str, **options: Any) -> subprocess.CompletedProcess[Any]:
    """A command in a process of its own, with pipes and environment as they are given."""
    line = f"from handcart.tools.main import main; main({list(words)!r})"
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return subprocess.run([sys.executable, "-c", line], check=False, timeout=LATEST_S, **given)


def shadow(folder: Path, name: str, text: str) -> dict[str, str]:
    """An environment in which a module is found that says this, before the true one."""
    (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return {**os.environ, "PYTHONPATH": str(folder)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("library", "command"), [("typer", "list"), ("pydantic", "schema"), ("networkx", "check"), ("cv2", "run")]
)
def test_a_library_that_cannot_be_imported_is_named(tmp_path: Path, library: str, command: str) -> None:
    """K13: with the line that installs it, and no traceback."""
    task = str(Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "task.yaml")
    words = {"list": ["robots"], "schema": ["task"]}.get(command, [task])
    said = say(command, *words, env=shadow(tmp_path, library, "raise ImportError('broken', name=__name__)"))
    assert said.returncode == 2
    assert f"the library {library} can't be imported: broken; to install: ".encode() in said.stderr
    assert b"-m pip install" in said.stderr
    assert b"Traceback" not in said.stderr


def test_every_command_names_libraries_that_are_too_old_or_missing(
    handcart: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K13: all of them at once, before anything is done."""
    (tmp_path / "numpy-1.26.4.dist-info").mkdir()
    (tmp_path / "opencv_python_headless-5.0.0.1.dist-info").mkdir()
    handcart_itself = tmp_path / "handcart-0.1.0.dist-info"
    handcart_itself.mkdir()
    needs = ["numpy>=2.0", "opencv-python-headless<5,>=4.10", "scipy>=1.14", "no-such-library>=1.0"]
    lines = "".join(f"Requires-Dist: {need}\n" for need in needs)
    (handcart_itself / "METADATA").write_text(f"Name: handcart\n{lines}\nRequires-Dist: text>=1\n")
    monkeypatch.syspath_prepend(tmp_path)
    for command in OWN_COMMANDS:
        said = handcart(*command.split(), "--help")
        assert said.status == 2
        assert "the library numpy is 1.26.4; needed: >=2.0; " in said.err
        assert "opencv-python-headless is 5.0.0.1; needed: <5,>=4.10" in said.err
        assert "the library no-such-library is missing; to install: " in said.err
        assert "pip install 'numpy>=2.0' 'opencv-python-headless<5,>=4.10' 'no-such-library>=1.0'" in said.err


@pytest.mark.slow
@pytest.mark.parametrize("how", ["closed", "full", "unread"])
def test_stdout_that_takes_nothing_is_told_in_a_sentence(how: str) -> None:
    """K14: how the command ended is its status, whatever becomes of its words."""
    options: dict[str, Any] = {}
    if how == "closed":
        options["preexec_fn"] = lambda: os.close(1)
    reading, writing = os.pipe()
    os.close(reading)
    with open("/dev/full", "wb") as full:
        options["stdout"] = {"full": full, "unread": writing}.get(how)
        said = say("list", "robots", **options)
    os.close(writing)
    assert said.returncode == 0
    assert b"stdout can't be written: " in said.stderr
    assert len(said.stderr.splitlines()) == 1


def test_a_name_that_is_no_text_is_refused(tour: Path) -> None:
    """K14: before the run, not at its summary."""
    said = say("run", str(tour), "--runs", os.fsdecode(b"r\xff"))
    assert said.returncode == 2
    assert said.stderr == b"the word r\\udcff is not UTF-8; allowed: names of files in UTF-8\n"


def test_a_link_that_leads_nowhere_is_no_runs_folder(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    (tmp_path / "runs").symlink_to(tmp_path / "nowhere")
    said = handcart("run", tour, "--runs", tmp_path / "runs")
    assert said.status == 2
    assert "runs is not a folder" in said.err
    assert not (tmp_path / "nowhere").exists()


@pytest.mark.slow
def test_nobody_listens_and_it_stops_all_the_same(tour: Path, tmp_path: Path) -> None:
    """K14: a pipe that is closed at its other end doesn't stop the stop; stderr is what a drive writes to."""
    reading, writing = os.pipe()
    process = python(
        "from handcart.tools.main import main",
        f"main(['run', {str(tour)!r}, *{ON_CAN!r}, '--runs', {str(tmp_path / 'runs')!r}])",
        stdout=subprocess.DEVNULL,
        stderr=writing,
    )
    os.close(writing)
    end = time.monotonic() + LATEST_S
    while not any(b'"kind":"START"' in path.read_bytes() for path in (tmp_path / "runs").rglob("*.jsonl")):
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.02)
    os.close(reading)
    process.send_signal(signal.SIGINT)
    process.wait(timeout=LATEST_S)
    (journal,) = (tmp_path / "runs").rglob("journal.jsonl")
    last = json.loads(journal.read_bytes().splitlines()[-1])
    assert last["kind"] == "END"
    assert last["outcome"] in ("Cancelled", "Error")


@pytest.mark.parametrize("module", ["inspect", "handcart.files.errors", "typer", "handcart.tools.commands"])
def test_ctrl_c_during_the_imports_prints_no_traceback(module: str) -> None:
    """The first second of a command is spent in imports; a person who mistyped it presses Ctrl-C there."""
    process = python(
        "import os, signal, sys",
        "class CtrlC:",
        "    def find_spec(name, path=None, target=None):",
        f"        if name == {module!r}:",
        "            print('pressed', flush=True)",
        "            os.kill(os.getpid(), signal.SIGINT)",
        "sys.meta_path.insert(0, CtrlC)",
        "from handcart.tools.main import main",
        "main(['list', 'robots'])",
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    out, said = process.communicate(timeout=LATEST_S)
    assert (process.returncode, out, said) == (130, b"pressed\n", b"")
