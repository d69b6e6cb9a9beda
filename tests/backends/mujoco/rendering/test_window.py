"""MuJoCo's viewer on a display of its own."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest

PROGRAM = """
import time
from pathlib import Path
from handcart.networks.task.preparing import prepare

with prepare(Path("tasks/stack_blocks/task.yaml"), "mujoco", {}, 0, window=True) as prepared:
    backend = prepared.backend
    began = time.monotonic()
    for _ in range(20):
        backend.step()
    assert time.monotonic() - began > 0.9, "a second passed in less"
    looks = backend._engine.looks
    looks.sheets.append(looks.sheets[0])  # something is new: it is opened again
    backend.step()
    assert backend._window._handle.is_running()
    backend._window.close()
    backend.step()  # closed by who looks on, the run goes on
print("shown")
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="there is no Xvfb; apt install xvfb")
def test_it_shows_a_run_as_fast_as_time_passes() -> None:
    command = ["xvfb-run", "-a", sys.executable, "-W", "error", "-c", PROGRAM]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (ended.returncode, ended.stdout) == (0, "shown\n"), ended.stderr
