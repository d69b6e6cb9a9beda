"""Behaviour of the kit when its parent process is killed."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

LINUX = Path("/proc/self/task").exists()


def running(process: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    stat = Path(f"/proc/{process}/stat")
    try:
        return stat.read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def children(process: int) -> list[int]:
    found = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8")
    return [int(part) for part in found.split()]


@pytest.mark.slow
@pytest.mark.skipif(not LINUX, reason="asks /proc who a process has started")
def test_no_process_of_the_kit_outlives_it() -> None:
    words = ["conformance", "--backend", "kinematic", "--part", "faults", "--primitive", "MOVE_TO"]
    kit = subprocess.Popen(
        [sys.executable, "-m", "handcart", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    end = time.monotonic() + 60.0
    try:
        while len(started := children(kit.pid)) < 2:
            assert time.monotonic() < end
            time.sleep(0.05)
        time.sleep(3.0)
    finally:
        kit.kill()
        kit.wait()
    while any(running(item) for item in started):
        assert time.monotonic() < end, "a worker outlives the kit"
        time.sleep(0.1)
