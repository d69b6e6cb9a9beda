"""Output of a running run, in a terminal and in a pipe."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from handcart.robotics.numerics.compiled import compiled, hearing_of_compiling
from handcart.tools.terminal.next_steps import ended_words, next_steps
from handcart.tools.terminal.progress import COMPILING_MESSAGE, Progress
from tests.tools.conftest import Said


def typed_into(words: list[str], answer: bytes = b"", upon: bytes = b"?") -> tuple[str, int]:
    """Return a command's output on a terminal, without colours; `answer` is typed once `upon` is seen."""
    ours, theirs = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "200"}
    with subprocess.Popen(words, stdin=theirs, stdout=theirs, stderr=theirs, env=environment) as process:
        os.close(theirs)
        shown = b""
        try:
            while got := os.read(ours, 65_536):
                shown += got
                if answer and upon in shown:
                    os.write(ours, answer)
                    answer = b""
        except OSError:  # the terminal is closed once the process has ended
            pass
        os.close(ours)
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode()), process.returncode


@pytest.mark.slow
def test_terminal_shows_loading_progress_and_next_steps(tour: Path) -> None:
    runs = tour.parent / "runs"
    words = [sys.executable, "-m", "handcart", "run", str(tour), "--runs", str(runs)]
    shown, status = typed_into(words)
    assert status == 0
    assert "loading" in shown
    far = [int(match) for match in re.findall(r"MOVE_TO: at_home to at_shelf  (\d+) of about 30 s", shown)]
    assert far
    assert far == sorted(far)
    assert far[-1] > 5
    assert f"handcart view {runs / 'tour-0'}" in shown
    assert str(runs / "tour-0" / "report.html") in shown


@pytest.mark.slow
def test_question_is_answered_by_hand_and_names_its_commands(tour: Path) -> None:
    runs = tour.parent / "runs with a space"
    words = [sys.executable, "-m", "handcart", "run", str(tour), "--runs", str(runs), "--step"]
    shown, status = typed_into(words, b"y\n", b"handcart refuse")
    assert status == 0
    assert "may MOVE_TO (at_home to at_shelf) start? y or n and Enter, or:" in shown
    assert f"handcart permit '{runs / 'tour-0'}'" in shown


def test_compiling_is_told_once_and_never_of_what_is_compiled_already(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("numba.core.dispatcher.Dispatcher.enable_caching", lambda _: None)

    def inner(x: float) -> float:
        return x + 1.0

    def outer(x: float) -> float:
        return 2.0 * added(x)

    added = compiled(inner)
    doubled = compiled(outer)
    heard: list[bool] = []
    with hearing_of_compiling(heard.append):
        assert doubled(1.0) == 4.0
        assert heard == [True, False]
        assert doubled(2.0) == 6.0
    assert heard == [True, False]
    with Progress():
        for again in (added, doubled):
            again(cast(float, np.float32(1.0)))  # of another type: compiled again
    assert capsys.readouterr().err.count(COMPILING_MESSAGE) == 1


def test_cancelled_run_says_that_the_robot_stopped_and_how_to_resume() -> None:
    summary = {"outcome": "Cancelled", "situation": "at_a", "reason": "interrupted", "run_dir": "runs/a-0"}
    stopped = "the robot has stopped, the state of the run is kept in runs/a-0; to resume:"
    assert ended_words(summary) == f"Cancelled in situation at_a: interrupted; {stopped}"
    assert next_steps(summary) == ["handcart resume runs/a-0"]
    summary |= {"outcome": "Success", "reason": ""}
    assert ended_words(summary) == "Success in situation at_a; see runs/a-0"


@pytest.mark.parametrize(
    ("outcome", "first"),
    [("Success", "view"), ("Fail", "explain"), ("GiveUp", "explain"), ("Cancelled", "resume")],
)
def test_what_may_be_done_next_can_be_pasted(tmp_path: Path, outcome: str, first: str) -> None:
    folder = tmp_path / "a run"
    steps = next_steps({"run_dir": str(folder), "outcome": outcome})
    assert steps[0] == f"handcart {first} '{folder}'"
    assert not any("report.html" in step for step in steps)
    folder.mkdir()
    (folder / "report.html").touch()
    assert next_steps({"run_dir": str(folder), "outcome": outcome})[-1] == str(folder / "report.html")


@pytest.mark.slow
def test_stdout_holds_the_result_alone(handcart: Callable[..., Said], tour: Path) -> None:
    said = handcart("run", tour, "--runs", tour.parent / "runs")
    assert len(said.out.splitlines()) == 1
    assert f"handcart view {tour.parent / 'runs' / 'tour-0'}" in said.err
