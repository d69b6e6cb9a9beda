"""Run tasks with a faulty lidar: `python -m benchmarks.driving.lidar_faults --seeds 20`

Each task runs with a lidar that sees 180 degrees (`--view`). In each period, 5 percent (`--percent`) of
its beams each read zero, NaN, -infinity and the robot's own body. Prints how many runs reach the goal, how
many have outcomes that the ground truth contradicts, and how many have unintended contacts, for each task
and of all. Status 1 if a run failed, touched something or had a false outcome. After Ctrl-C it reports on
the runs until then.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml
from rich.console import Console
from rich.progress import track

from benchmarks.cut_off import CutOff
from handcart.backends.description.robot_names import robot_path
from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial import Trial

TASKS_FOLDER = Path(__file__).resolve().parents[2] / "tasks"
LIDAR_FAULTS = (
    "range_zero_percent",
    "range_nan_percent",
    "range_too_close_percent",
    "range_own_body_percent",
)


def faulty_robot(name: str, folder: Path, percent: float, view: float) -> Path:
    """Write a copy of a shipped robot with such a lidar, and return its path."""
    file = robot_path(name)
    copy = folder / name
    shutil.copytree(file.parent, copy)
    content: dict[str, Any] = yaml.safe_load(file.read_text(encoding="utf-8"))
    content["range_sensor"] |= {"range_min_m": 0.1, "start_deg": -view / 2, "end_deg": view / 2}
    content["range_sensor"]["beams"] = round(view) + (view < 360.0)
    content["errors"] |= dict.fromkeys(LIDAR_FAULTS, percent)
    (copy / file.name).write_text(yaml.safe_dump(content), encoding="utf-8")
    return copy / file.name


def contacts(trial: Trial) -> int:
    """Return how many contacts of a run no action means."""
    return int(trial.summary.get("metrics", {}).get("contacts_unmeant", 0) or 0)


def main() -> None:
    """Print the table."""
    words = argparse.ArgumentParser(
        prog="python -m benchmarks.driving.lidar_faults",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    words.add_argument("--seeds", type=int, default=20)
    words.add_argument("--first", type=int, default=0, help="the first seed")
    words.add_argument("--percent", type=float, default=5.0, help="of the beams, of each kind of fault")
    words.add_argument("--view", type=float, default=180.0, help="field of view in degrees")
    words.add_argument("--tasks", nargs="+", default=["drive_map", "return_book"])
    words.add_argument("--robot", default="librarian")
    words.add_argument("--backend", default=None)
    words.add_argument("--jobs", type=int, default=1)
    words.add_argument("--runs", type=Path, default=None, help="folder to keep the runs in")
    chosen = words.parse_args()
    print(f"{'':16}{'Success':>10}{'false':>8}{'contacts':>10}   other ends", flush=True)
    every = list[Trial]()
    with tempfile.TemporaryDirectory() as folder, CutOff() as cut:
        robot = faulty_robot(chosen.robot, Path(folder), chosen.percent, chosen.view)
        for name in chosen.tasks:
            setting = CampaignSetting(
                TASKS_FOLDER / name / "task.yaml",
                chosen.backend,
                {"robot": str(robot)},
                runs=chosen.runs or Path(folder) / "runs",
            )
            seeds = range(chosen.first, chosen.first + chosen.seeds)
            running = run_campaign(setting, seeds, chosen.jobs)
            trials = list[Trial]()
            try:
                for trial in track(running, name, chosen.seeds, console=Console(stderr=True)):
                    trials.append(trial)
            finally:
                every += trials
                print("\n".join(task_lines(name, trials)), flush=True)
    print(sum_line(every))
    sys.exit(cut.status(not every or any(map(went_wrong, every))))


def task_lines(name: str, trials: Sequence[Trial]) -> Iterator[str]:
    """Yield the table's row of a task, and a line for each of the most frequent other ends."""
    good, false, touched = counts_of(trials)
    yield f"{name:16}{good:>4} / {len(trials):<3}{false:>8}{touched:>10}"
    ends = Counter(
        f"{trial.summary['outcome']}: {trial.summary.get('reason', '')}"
        for trial in trials
        if not trial.success
    )
    for end, count in ends.most_common(3):
        yield f"{'':18}{count} x {end[:150]}"


def sum_line(trials: Sequence[Trial]) -> str:
    """Return the result of all runs: share of Success, false outcomes, unintended contacts."""
    good, false, touched = counts_of(trials)
    share = 100.0 * good / max(1, len(trials))
    return (
        f"Success in {good} of {len(trials)} runs ({share:.1f} %); with false outcomes: {false}; "
        f"with unintended contacts: {touched}"
    )


def counts_of(trials: Sequence[Trial]) -> tuple[int, int, int]:
    """Return how many runs succeeded, had a false outcome, and had an unintended contact."""
    return (
        sum(trial.success for trial in trials),
        sum(bool(trial.untrue) for trial in trials),
        sum(contacts(trial) > 0 for trial in trials),
    )


def went_wrong(trial: Trial) -> bool:
    """Return whether a run failed, touched something or had a false outcome."""
    return counts_of([trial]) != (1, 0, 0)


if __name__ == "__main__":
    main()
