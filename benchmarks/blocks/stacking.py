"""Measure the errors of stacked blocks by method and arm: Hatano et al. (2000) and later methods.

python -m benchmarks.blocks.stacking [EXPERIMENTS [ROW ...]] [--plots FOLDER]

An experiment is 20 trials of five blocks (of the fence: 15); "max" is the median over the experiments of
each one's largest error. ROW is a part of a row's name.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import track

from benchmarks.blocks.stacking_experiment import TRIAL_COUNT, experiments_of, run_trials
from benchmarks.blocks.stacking_plots import plot_against_motion, plot_by_block

TASKS_FOLDER = Path(__file__).parent.parent.parent / "tasks"
UNLOAD, WHOLE = TASKS_FOLDER / "stack_blocks" / "unload.yaml", TASKS_FOLDER / "stack_blocks" / "task.yaml"
FENCE_TASK = TASKS_FOLDER / "build_fence" / "task.yaml"
SERVO_SETTINGS = {
    "world": str(TASKS_FOLDER / "stack_blocks" / "servo_world.yaml"),
    "building": str(TASKS_FOLDER / "stack_blocks" / "servo_building.yaml"),
}
PAPER_SETTINGS = {"method": "fix_once", "rule": "paper", "look": "false"}


class Row(NamedTuple):
    """A line of the table."""

    task: Path
    robot: str
    settings: dict[str, str]
    blocks: int = 5


ARM_ROBOTS = {"H1": "toyama/h1", "H2": "toyama"}
FIXING_METHODS = ("fix_once", "model", "imu", "fix_again", "fix_again_model", "fix_again_imu")
TABLE_ROWS = {
    "paper's method, H2, unload to stack": Row(UNLOAD, "toyama", PAPER_SETTINGS),
    "paper's method, H2, whole operation": Row(WHOLE, "toyama", PAPER_SETTINGS),
    **{
        f"{method}, {arm}, unload to stack": Row(UNLOAD, robot, {"method": method, "look": "false"})
        for arm, robot in ARM_ROBOTS.items()
        for method in FIXING_METHODS
    },
    **{
        f"look, {method}, {arm}, unload to stack": Row(UNLOAD, robot, {"method": method, **world})
        for arm, robot in ARM_ROBOTS.items()
        for method, world in (("fix_again_imu", {}), ("servo", SERVO_SETTINGS))
    },
    "look, fix_again_imu, H1, whole operation": Row(WHOLE, "toyama/h1", {"method": "fix_again_imu"}),
    "fence, look, fix_again_imu, H1": Row(FENCE_TASK, "toyama/h1", {"method": "fix_again_imu"}, 15),
}


def main() -> None:
    """Print the table."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("experiments", nargs="?", type=int, default=10)
    words.add_argument("row", nargs="*", help="parts of rows' names; default: all")
    words.add_argument("--plots", type=Path, help="folder for drawings")
    wanted = words.parse_args()
    plots, count = wanted.plots, wanted.experiments
    chosen = {
        name: row for name, row in TABLE_ROWS.items() if any(item in name for item in wanted.row or [""])
    }
    head = f"{'|E| in mm, experiments: ' + str(count):42}{'mean':>7}{'max':>7}{'processed':>11}"
    print(head + f"{'E_x, E_y grow':>15}{'frames':>8}{'s':>6}{'lost':>6}")
    for name, row in chosen.items():
        with tempfile.TemporaryDirectory() as runs:
            running = run_trials(
                row.task, {"robot": row.robot, **row.settings}, range(TRIAL_COUNT * count), Path(runs)
            )
            trials = list(track(running, name, TRIAL_COUNT * count, console=Console(stderr=True)))
        found = experiments_of(trials, row.blocks)
        uncorrected = row.settings["method"] == "fix_once"
        processed = f"{found.median_of_maxima(processed=True):11.2f}" if uncorrected else f"{'':11}"
        grow = "{:.2f}, {:.2f}".format(*found.growth())
        print(
            f"{name:42}{found.mean:7.2f}{found.median_of_maxima():7.2f}{processed}{grow:>15}"
            f"{found.frames:8.1f}{found.sim_time:6.0f}{len(found.lost):6}",
            flush=True,
        )
        for text in found.lost:
            print(f"    {text}")
        if plots is not None:
            plots.mkdir(parents=True, exist_ok=True)
            label = name.replace(",", "").replace("'", "").replace(" ", "_")
            plot_against_motion(found.each[0], plots / f"{label}_motion.svg")
            plot_by_block(found.each[0], plots / f"{label}_blocks.svg")


if __name__ == "__main__":
    main()
