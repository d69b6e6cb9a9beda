"""How long a first run takes until the robot moves, all inner loops compiled anew.

python -m benchmarks.first_run [TASK ...]

Each is `handcart run` in a process of its own, with an empty folder for machine code; it is ended as soon as
it has said what comes before the first motion. Seconds by the clock, and of the processor for that process
alone: other cores compile as well.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BEGINS = "stops the base"
TASKS = {"return_book": BEGINS, "stack_blocks": BEGINS, "deploy_straight": BEGINS, "track_seam": "1. DIVIDE"}
"""By name: what it says before it moves; DIVIDE only thinks."""


def before_motion(task: str) -> tuple[float, float]:
    """Seconds by the clock and of the processor."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        words = [
            "-m",
            "handcart",
            "run",
            f"tasks/{task}/task.yaml",
            "--no-report",
            "--runs",
            f"{folder}/runs",
        ]
        env = {**os.environ, "NUMBA_CACHE_DIR": f"{folder}/code", "OMP_NUM_THREADS": "1"}
        begun, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
        process = subprocess.Popen(
            [sys.executable, *words],
            cwd=Path(__file__).parents[1],
            env=env,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        with process:
            assert process.stderr is not None
            said = next((line for line in process.stderr if TASKS[task] in line), None)
            took = time.monotonic() - begun
            process.kill()
        if said is None:
            raise RuntimeError(f"{task} ended before it moved, with status {process.returncode}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return took, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the table."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    words.add_argument("tasks", nargs="*", metavar="TASK", help=f"of {', '.join(TASKS)} (default: all)")
    given = words.parse_args().tasks or list(TASKS)
    if unknown := sorted(set(given) - set(TASKS)):
        words.error(f"{', '.join(unknown)}: not known; there are {', '.join(TASKS)}")
    print(f"{'before it moves':18}{'s':>8}{'CPU s':>8}")
    for task in given:
        took, cpu = before_motion(task)
        print(f"{task:18}{took:8.1f}{cpu:8.1f}", flush=True)


if __name__ == "__main__":
    main()
