"""Record the readings of shipped tasks, and replay them: the commands must be the same to the last bit.

    python -m benchmarks.contract.sensor_replay [--backends kinematic,mujoco] [--tasks WORD] [--seed 0]
                                                [--short] [--set NAME=VALUE]

A replay has no world behind it, so a primitive that reads anything but sensors commands something else.
Prints a line for each task and backend with the size of the recording, and the number that is bit-equal;
status 1 if one is not.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from handcart.evaluation.conformance.faults.repertoire import declared
from handcart.evaluation.sensor_replay.recording_file import SENSORS_FILE
from handcart.evaluation.sensor_replay.sensor_replay import replay_sensors
from handcart.evaluation.trials.running import run_task
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.runs.run_options import RunOptions
from handcart.tasks.task_names import named_tasks


def replayed(task: Path, backend: str, seed: int, settings: Mapping[str, str]) -> tuple[str, bool]:
    """Run a task and replay it; return a line about it, and whether all commands are the same."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.process_time()
        options = RunOptions(backend=backend, seed=seed, settings=settings, record_sensors=True)
        summary, _ = run_task(task, Path(folder), options)
        run_dir = Path(summary["run_dir"])
        size = (run_dir / SENSORS_FILE).stat().st_size / 2**20
        ran = time.process_time() - begun
        found = replay_sensors(read_run(run_dir))
    took = time.process_time() - begun - ran
    verdict = found.difference or "bit-equal"
    head = f"{summary['outcome']}, {summary['sim_time_s']:.0f} s, {size:.1f} MiB; {found.commands} commands"
    return f"{head}, CPU {ran:.0f} + {took:.0f} s: {verdict}", not found.difference


def main() -> None:
    """Print a line for each task and backend."""
    words = argparse.ArgumentParser(
        prog="python -m benchmarks.contract.sensor_replay",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    words.add_argument("--backends", default="kinematic,mujoco")
    words.add_argument("--tasks", default="", help="only those with this in their names")
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a task's parameter")
    words.add_argument("--short", action="store_true", help="as short as the conformance kit runs them")
    given = words.parse_args()
    equal, total, short = 0, 0, declared() if given.short else {}
    chosen = dict(item.split("=", 1) for item in given.set)
    for name, task in named_tasks().items():
        for backend in given.backends.split(","):
            if given.tasks in name:
                print(f"{name:<22}{backend:<10}", end="", flush=True)
                line, same = replayed(task, backend, given.seed, {**short.get(task, {}), **chosen})
                print(line, flush=True)
                equal, total = equal + same, total + 1
    print(f"{equal} of {total} runs are bit-equal when replayed from their readings")
    raise SystemExit(0 if equal == total else 1)


if __name__ == "__main__":
    main()
