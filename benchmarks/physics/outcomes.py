"""Compare the outcomes of two backends.

    python -m benchmarks.physics.outcomes [TASK] [SEEDS] [BACKENDS]

A task, `return_book` by default, is run with each seed on each backend (`mujoco,pybullet`), alternately in
one process. Compared are actions and their outcomes, in their order. Prints the differences, the median
CPU time of a run on each backend without pictures and report, and the ratio.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from handcart.evaluation.trials.running import run_task
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.runs.run_options import RunOptions

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "task.yaml"
BACKEND_NAMES = "mujoco,pybullet"

Outcomes = list[tuple[str, str]]


def outcomes(task: Path, backend: str, seed: int) -> tuple[Outcomes, list[str], float]:
    """Return a run's actions with their outcomes, its untrue outcomes, and its CPU time [s]."""
    options = RunOptions(backend=backend, seed=seed, draw=False, report=False, playback=False)
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        summary, _ = run_task(task, Path(folder), options)
        spent = time.process_time() - began
        path = next(Path(folder).glob("*/journal.jsonl"))
        records = read_journal(path).records
    names = {record["n"]: record["action"]["do"] for record in records if record["kind"] == "START"}
    ended = [(names[record["n"]], record["outcome"]) for record in records if record["kind"] == "RESULT"]
    return ended, summary["metrics"].get("untrue", []), spent


def main() -> None:
    """Print a line for each seed, and the sum."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("task", nargs="?", type=Path, default=TASK_FILE)
    words.add_argument("seeds", nargs="?", type=int, default=20)
    words.add_argument("backends", nargs="?", default=BACKEND_NAMES)
    wanted = words.parse_args()
    task, seeds = wanted.task, wanted.seeds
    one, other = wanted.backends.split(",")
    spent: list[tuple[float, float]] = []
    same = 0
    for seed in range(seeds):
        (first, lies, took), (second, others_lies, took_too) = (
            outcomes(task, backend, seed) for backend in (one, other)
        )
        spent.append((took, took_too))
        same += first == second
        print(f"seed {seed:2d}: {'same' if first == second else f'{one} {first}, {other} {second}'}", end="")
        print(f"; untrue {len(lies)}, {len(others_lies)}; {took:.1f} s, {took_too:.1f} s", flush=True)
    medians = np.median(spent, axis=0)
    print(f"same actions and outcomes: {same} of {seeds} seeds")
    print(
        f"CPU of a run: {one} {medians[0]:.2f} s, {other} {medians[1]:.2f} s, {medians[0] / medians[1]:.2f}"
    )


if __name__ == "__main__":
    main()
