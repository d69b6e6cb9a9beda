"""Run shipped tasks over the bench of ROS 2 topics: `python -m benchmarks.ros2.tasks`.

Each task is run with each seed as `handcart run TASK --backend ros2 --bench BACKEND` does it: commands and
readings pass through the messages of ROS, in one process and without its middleware. Printed are the
Successes, the outcomes that the ground truth contradicts, and the reasons of all other ends. Status 1 if an
outcome was false or fewer than 95 % were Successes. Ctrl-C, or a signal to end, stops the run, and the row is
printed with the runs until then; status 130.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.cut_off import CUT_OFF_STATUS
from handcart.evaluation.trials.running import run_task
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.runs.run_options import RunOptions
from handcart.tasks.task_names import task_path

TASK_NAMES = ("return_book", "stack_blocks", "drive_map", "fetch_and_carry")
MIN_SUCCESS_RATIO = 0.95


@dataclass
class Figures:
    """Results of the runs of one task on one simulated backend."""

    runs: int = 0
    wanted: int = 0
    """Runs that were asked for; more than `runs` if the row was cut off."""
    ends: Counter[str] = field(default_factory=Counter)
    false: list[str] = field(default_factory=list)
    simulated_s: float = 0.0
    cpu_s: float = 0.0

    @property
    def is_good(self) -> bool:
        """True if nothing was false and at least 95 % were Successes."""
        return not self.false and self.ends["Success"] >= MIN_SUCCESS_RATIO * self.runs


def main() -> None:
    """Print a row for each task and simulated backend."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--tasks", nargs="+", default=list(TASK_NAMES))
    words.add_argument("--benches", nargs="+", default=["kinematic", "mujoco"], help="simulated backends")
    words.add_argument("--seeds", type=int, default=20, help="number of seeds on the kinematic bench")
    words.add_argument("--physics-seeds", type=int, default=5, help="number of seeds on every other bench")
    words.add_argument("--first", type=int, default=0, help="first seed")
    asked = words.parse_args()
    rows: list[Figures] = []
    with Interrupts() as heard:
        for bench in asked.benches:
            count = asked.seeds if bench == "kinematic" else asked.physics_seeds
            for task in asked.tasks:
                rows.append(measure(task, bench, range(asked.first, asked.first + count), heard))
                print(row_of(task, bench, rows[-1]), flush=True)
                if heard.came:
                    sys.exit(CUT_OFF_STATUS)
    sys.exit(0 if all(row.is_good for row in rows) else 1)


def measure(task: str, bench: str, seeds: range, heard: Interrupts) -> Figures:
    """Run a task with some seeds over the bench in front of a simulated backend.

    Args:
        task: name of the task.
        bench: name of the simulated backend.
        seeds: seeds of the runs.
        heard: handler of Ctrl-C; a run that it stops is not counted, and no further one begins.
    """
    found = Figures(wanted=len(seeds))
    for seed in seeds:
        print(f"{task} on {bench}, seed {seed} ...", end=" ", file=sys.stderr, flush=True)
        begun = time.process_time()
        try:
            summary = run_once(task, bench, seed, heard)
        except KeyboardInterrupt:
            heard.came = True
        if heard.came:
            print("cut off", file=sys.stderr, flush=True)
            break
        found.runs += 1
        found.cpu_s += time.process_time() - begun
        found.simulated_s += summary["sim_time_s"]
        success = summary["outcome"] == "Success"
        found.ends["Success" if success else f"{summary['outcome']}: {summary['reason'][:160]}"] += 1
        found.false += [f"seed {seed}: {item}" for item in summary["metrics"]["untrue"]]
        print(f"{summary['outcome']} {summary['reason']}", file=sys.stderr, flush=True)
    return found


def run_once(task: str, bench: str, seed: int, heard: Interrupts) -> dict[str, Any]:
    """Run a task once over the bench, and return its summary."""
    with TemporaryDirectory(prefix="ros2-") as folder:
        options = RunOptions(backend="ros2", seed=seed, bench=bench, interrupts=heard)
        summary, _ = run_task(task_path(Path(task)), Path(folder), options)
    return summary


def row_of(task: str, bench: str, found: Figures) -> str:
    """Return the printed row, with the other ends and the false outcomes below it."""
    head = f"{task:<16}{bench:<10} Success {found.ends['Success']}/{found.runs}  false {len(found.false)}"
    if found.runs < found.wanted:
        head += f"  cut off after {found.runs} of {found.wanted} runs"
    speed = found.simulated_s / max(found.cpu_s, 1e-9)
    others = [f"    {count} x {end}" for end, count in found.ends.items() if end != "Success"]
    wrong = [f"    false: {item}" for item in found.false]
    return "\n".join([f"{head}  {found.cpu_s:.0f} CPU s, {speed:.1f} times real time", *others, *wrong])


if __name__ == "__main__":
    main()
