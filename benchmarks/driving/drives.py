"""Tours of a map with drives of each kind, on two backends: python -m benchmarks.driving.drives

Each run is the task drive_map with one seed: six places, 38 m. A run counts if it ends in Success, the
judge finds no claim false, and the base touches nothing.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASK = Path(__file__).resolve().parents[2] / "tasks" / "drive_map" / "task.yaml"
ROBOTS = {"holonomic": "cart/mecanum", "skid-steer": "cart/skid", "two wheels": "cart"}
BACKENDS = ("kinematic", "mujoco")


class Tour(NamedTuple):
    """Result of one run."""

    outcome: str
    contacts: int
    false: int
    arrival_mm: float
    seconds: float
    reason: str

    @property
    def counts(self) -> bool:
        """True if the run was a Success without contact."""
        return self.outcome == "Success" and not self.contacts and not self.false


def tour(robot: str, backend: str, seed: int, task: Path = TASK) -> Tour:
    """Run the task once."""
    with tempfile.TemporaryDirectory() as runs:
        options = RunOptions(backend=backend, seed=seed, settings={"robot": robot})
        summary, _ = run_task(task, Path(runs), options)
    metrics = summary["metrics"]
    return Tour(
        summary["outcome"],
        int(metrics["contacts_of_base"]),
        len(metrics["untrue"]),
        float(metrics["arrival_mm_max"]),
        float(summary["sim_time_s"]),
        summary["reason"],
    )


def line(kind: str, backend: str, tours: list[Tour]) -> str:
    """Return what was found for one kind of drive."""
    right = sum(tour_.counts for tour_ in tours)
    contacts, false = sum(tour_.contacts for tour_ in tours), sum(tour_.false for tour_ in tours)
    off, took = max(tour_.arrival_mm for tour_ in tours), np.median([tour_.seconds for tour_ in tours])
    return (
        f"{kind:11} {backend:10} {right} of {len(tours)} Success ({100.0 * right / len(tours):.0f} %); "
        f"contacts {contacts}; false outcomes {false}; arrival at most {off:.1f} mm off; median {took:.1f} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, help="runs of each drive and backend (default: 20)")
    parser.add_argument("--drive", choices=ROBOTS, help="this kind alone (default: all)")
    parser.add_argument("--backend", choices=BACKENDS, help="this one alone (default: both)")
    given = parser.parse_args()
    begun = time.process_time()
    for kind in (given.drive,) if given.drive else ROBOTS:
        for backend in (given.backend,) if given.backend else BACKENDS:
            tours = []
            for seed in range(given.seeds):
                tours.append(tour(ROBOTS[kind], backend, seed))
                last = tours[-1]
                note = "" if last.counts else f": {last.outcome} {last.reason}"
                print(f"  {kind} {backend} seed {seed}{note}", file=sys.stderr, flush=True)
            print(line(kind, backend, tours), flush=True)
    print(f"{time.process_time() - begun:.0f} s of CPU")


if __name__ == "__main__":
    main()
