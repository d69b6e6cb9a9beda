"""A child process ends together with the process that started it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

PARENT = """
import sys, time
from multiprocessing import get_context

def child(file):
    import os
    from pathlib import Path
    from handcart.evaluation.trials.with_parent import end_with_parent

    end_with_parent()
    Path(file).write_text(str(os.getpid()))
    time.sleep(300.0)

if __name__ == "__main__":
    get_context("spawn").Process(target=child, args=(sys.argv[1],)).start()
    time.sleep(300.0)
"""


def running(process: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    try:
        os.kill(process, 0)
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks /proc")
def test_it_ends_as_soon_as_that_is_killed(tmp_path: Path) -> None:
    script, file = tmp_path / "parent.py", tmp_path / "child"
    script.write_text(PARENT, encoding="utf-8")
    parent = subprocess.Popen([sys.executable, str(script), str(file)])
    end = time.monotonic() + 60.0
    while not file.exists() or not file.read_text(encoding="utf-8"):
        assert time.monotonic() < end
        time.sleep(0.02)
    child = int(file.read_text(encoding="utf-8"))
    assert running(child)
    parent.kill()
    parent.wait()
    while running(child):
        assert time.monotonic() < end
        time.sleep(0.02)
