"""Measure the CPU time of a trial, and its ratio to real time.

    python -m benchmarks.trial_speed [TASK ...] [--trials 3]

For each task a campaign of 1 and one of 1 + `--trials` trials on one worker; the difference gives the
trial, the rest of the former the start. CPU seconds, the minimum of two. `benchmarks.cpu_against` compares
with another checkout.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

REPOSITORY_ROOT = Path(__file__).parents[1]
TASK_NAMES = ("return_book", "stack_blocks", "track_seam", "deploy_straight")
ROUND_COUNT = 2


class Speed(NamedTuple):
    """Times of one task."""

    start_s: float
    trial_s: float


def measured(task: str, trials: int) -> Speed:
    """Return the CPU times of a start and of a trial."""
    one = _campaign(task, 1)
    many = _campaign(task, 1 + trials)
    trial = (many - one) / trials
    return Speed(one - trial, trial)


def _campaign(task: str, trials: int) -> float:
    words = ["campaign", f"tasks/{task}/task.yaml", "--trials", str(trials), "--jobs", "1"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [sys.executable, "-m", "handcart", *words],
            cwd=REPOSITORY_ROOT,
            env={**os.environ, "OMP_NUM_THREADS": "1", "TMPDIR": folder},
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def simulated_s(task: str) -> float:
    """Return the duration of a run in the robot's time [s]."""
    with tempfile.TemporaryDirectory() as folder:
        file = str(REPOSITORY_ROOT / "tasks" / task / "task.yaml")
        words = [file, "--json", "--runs", folder, "--no-report"]
        done = subprocess.run(
            [sys.executable, "-m", "handcart", "run", *words],
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
    return float(json.loads(done.stdout.splitlines()[-1])["sim_time_s"])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("tasks", nargs="*", default=TASK_NAMES)
    parser.add_argument("--trials", type=int, default=3)
    given = parser.parse_args()
    print(f"{'CPU s':18}{'start':>8}{'trial':>8}{'x real time':>13}")
    for task in given.tasks:
        _campaign(task, 1)  # compiles what hasn't been
        found = [measured(task, given.trials) for _ in range(ROUND_COUNT)]
        start, trial = map(min, zip(*found, strict=True))
        print(f"{task:18}{start:8.2f}{trial:8.2f}{simulated_s(task) / trial:13.1f}", flush=True)


if __name__ == "__main__":
    main()
