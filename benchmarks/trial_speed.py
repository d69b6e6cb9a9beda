"""Measure the CPU time of a trial, and its ratio to real time.

    python -m benchmarks.trial_speed [TASK ...] [--against CHECKOUT] [--trials 3]

For each task a campaign of 1 and one of 1 + `--trials` trials on one worker; the difference gives the
trial, the rest of the former the start. With `--against` the same in another checkout, whose virtual
environment is in its `.venv`, alternating with this one. CPU seconds, the minimum of two.
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
    """Times of one task in one checkout."""

    start_s: float
    trial_s: float


def measured(python: Path, checkout: Path, task: str, trials: int) -> Speed:
    """Return the CPU times of a start and of a trial."""
    one = _campaign(python, checkout, task, 1)
    many = _campaign(python, checkout, task, 1 + trials)
    trial = (many - one) / trials
    return Speed(one - trial, trial)


def _campaign(python: Path, checkout: Path, task: str, trials: int) -> float:
    words = ["campaign", f"tasks/{task}/task.yaml", "--trials", str(trials), "--jobs", "1"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [python, "-m", "handcart", *words]
            if checkout == REPOSITORY_ROOT
            else [python.parent / "handcart", *words],
            cwd=checkout,
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
    parser.add_argument("--against", type=Path)
    parser.add_argument("--trials", type=int, default=3)
    given = parser.parse_args()
    print(
        f"{'CPU s':18}{'start':>8}{'trial':>8}{'x real time':>13}{'other start':>13}{'trial':>8}{'ratio':>8}"
    )
    for task in given.tasks:
        sides = [(Path(sys.executable), REPOSITORY_ROOT)]
        if given.against is not None:
            other = given.against.resolve()
            sides.append((other / ".venv" / "bin" / "python", other))
        for side in sides:
            _campaign(*side, task, 1)  # compiles what hasn't been
        found = [[measured(*side, task, given.trials) for side in sides] for _ in range(ROUND_COUNT)]
        best = [Speed(*map(min, zip(*side, strict=True))) for side in zip(*found, strict=True)]
        start, trial = best[0]
        line = f"{task:18}{start:8.2f}{trial:8.2f}{simulated_s(task) / trial:13.1f}"
        for other_speed in best[1:]:
            ratio = trial / other_speed.trial_s
            line += f"{other_speed.start_s:13.2f}{other_speed.trial_s:8.2f}{ratio:8.2f}"
        print(line, flush=True)


if __name__ == "__main__":
    main()
