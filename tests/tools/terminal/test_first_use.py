"""Output of a command while it computes."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from handcart.files.shown_path import shown_path
from handcart.files.stages import begin_stage
from handcart.tools.main import main
from handcart.tools.terminal import first_use
from handcart.tools.terminal.first_use import COMPILING_MESSAGE, announced, first_words

ROOT = Path(__file__).resolve().parents[3]


def test_command_that_takes_long_says_what_it_does(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_use, "SILENT_TIME_S", 0.0)
    said, say = threading.Event(), first_use._say

    def say_and_note(words: str) -> None:
        say(words)
        said.set()

    monkeypatch.setattr(first_use, "_say", say_and_note)
    with announced("checking my.yaml"):
        assert said.wait(10.0)
    assert capsys.readouterr().err == "checking my.yaml ...\n"


def test_stage_that_takes_long_is_said_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_use, "SILENT_TIME_S", 0.02)
    with announced("checking my.yaml"):
        begin_stage("short")
        for _ in range(2):
            begin_stage("ways to the places")
            time.sleep(0.1)
    begin_stage("afterwards")
    assert capsys.readouterr().err == "checking my.yaml: ways to the places ...\n"


def test_first_words_are_not_said_once_more_is_known(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_use, "SILENT_TIME_S", 0.02)
    with first_words("loading my.yaml") as more_is_known:
        more_is_known()
        time.sleep(0.1)
    assert capsys.readouterr().err == ""


def test_run_says_what_it_loads_before_it_imports_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []

    @contextmanager
    def noted(what: str) -> Iterator[Callable[[], None]]:
        said.append(what)
        yield lambda: None

    monkeypatch.setattr(first_use, "first_words", noted)
    with pytest.raises(SystemExit):
        main(["run", "drive_map", "--from", "nowhere"])
    assert said == [f"loading {shown_path(ROOT / 'tasks/drive_map/task.yaml')}"]


def test_command_that_is_quick_says_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_use, "SILENT_TIME_S", 3600.0)
    with announced("checking my.yaml"):
        pass
    assert capsys.readouterr().err == ""


@pytest.mark.slow
def test_first_check_says_that_it_compiles(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "handcart", "check", "drive_map"]
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    ended = subprocess.run(words, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert ended.returncode == 0
    assert ended.stderr.count(COMPILING_MESSAGE) == 1


def test_announcing_does_not_import_numba(tmp_path: Path) -> None:
    code = (
        "import sys\n"
        "from handcart.tools.terminal.first_use import announced\n"
        "with announced('a command'):\n"
        "    print('numba' in sys.modules)"
    )
    words = [sys.executable, "-c", code]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ended.stdout == "False\n"
