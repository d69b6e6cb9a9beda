"""Household activities of BEHAVIOR-1K, judged by their evaluator: `python -m benchmarks.objects.activities`.

Each activity is made by `handcart activity` and run with each seed, as `handcart run` does it. Printed are,
for each activity, the runs whose end satisfies the goal by the evaluator of the package `bddl` on true poses,
those that satisfy it by our own survey, the Successes, the false outcomes, and the runs on which the two
verdicts differ, each with the reason of both. Status 1 if one of them differs, or an outcome was false.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from handcart.evaluation.activities.making import make
from handcart.evaluation.trials.running import run_task
from handcart.files.errors import InputError
from handcart.networks.runs.run_options import RunOptions

LIBRARIAN, TOYAMA, FETCH = "librarian", "toyama", "fetch"
ROBOTS = {
    "store_honey": LIBRARIAN,
    "collecting_wood": FETCH,
    "bringing_newspaper_in": FETCH,
    "putting_wood_in_fireplace": FETCH,
    "store_batteries": LIBRARIAN,
    "sending_packages": FETCH,
    "putting_meal_in_fridge_at_work": LIBRARIAN,
    "store_firewood": FETCH,
    "cleaning_parks": FETCH,
    "make_the_ultimate_spa_basket": LIBRARIAN,
    "bringing_in_kindling": FETCH,
    "hiding_Easter_eggs": TOYAMA,
    "packing_books_into_car": LIBRARIAN,
    "returning_videotapes_to_store": LIBRARIAN,
    "setting_up_room_for_games": LIBRARIAN,
    "store_beer": LIBRARIAN,
    "dispose_of_fireworks": TOYAMA,
    "picking_up_books_at_library": LIBRARIAN,
    "re_shelving_library_books": LIBRARIAN,
    "boxing_books_up_for_storage": LIBRARIAN,
    "collecting_childrens_toys": LIBRARIAN,
    "picking_up_trash": FETCH,
}
"""Activities whose things are rigid, and a robot whose fingers take them; those with few things to move come
first. The librarian does not take low things off the floor."""


@dataclass
class Row:
    """Results of an activity."""

    runs: int = 0
    bddl: int = 0
    ours: int = 0
    ends: Counter[str] = field(default_factory=Counter)
    false: list[str] = field(default_factory=list)
    differ: list[str] = field(default_factory=list)
    simulated_s: float = 0.0
    cpu_s: float = 0.0


def main() -> None:
    """Print a row for each activity."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--activities", type=int, default=len(ROBOTS), help="number of activities")
    words.add_argument("--names", nargs="+", default=None, help="these activities instead")
    words.add_argument("--seeds", type=int, default=20, help="number of seeds, from --first")
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--backend", default="kinematic")
    words.add_argument("--robot", default=None, help="name or file of the robot (default: by activity)")
    words.add_argument("--scale", action="store_true", help="make narrower what the fingers can't take")
    asked = words.parse_args()
    names = asked.names or list(ROBOTS)[: asked.activities]
    rows: dict[str, Row | str] = {}
    for name in names:
        try:
            rows[name] = measure(name, range(asked.first, asked.first + asked.seeds), asked)
        except InputError as error:
            rows[name] = str(error)
    sys.exit(print_rows(rows))


def measure(name: str, seeds: Sequence[int], asked: argparse.Namespace) -> Row:
    """Make an activity and run it with some seeds."""
    row = Row()
    with TemporaryDirectory(prefix="activity-") as folder:
        make(name, 0, Path(folder), asked.robot or ROBOTS.get(name, LIBRARIAN), asked.scale)
        for seed in seeds:
            begun = time.process_time()
            options = RunOptions(backend=asked.backend, seed=seed)
            summary, _ = run_task(Path(folder) / "task.yaml", Path(folder) / "runs", options)
            row.cpu_s += time.process_time() - begun
            _count(row, seed, summary)
            end = f"{summary['outcome']} {summary['reason']}"[:160]
            print(f"{name} seed {seed}: {end}", file=sys.stderr, flush=True)
    return row


def print_rows(rows: dict[str, Row | str]) -> int:
    """Print the rows and their sums; return the exit status."""
    print(f"{'activity':<34}{'bddl':>8}{'ours':>8}{'Success':>9}{'false':>7}{'differ':>8}{'x real time':>13}")
    measured = {name: row for name, row in rows.items() if isinstance(row, Row)}
    for name, row in rows.items():
        if isinstance(row, str):
            print(f"{name:<34}  {row}")
            continue
        done = f"{row.ends['Success']}/{row.runs}"
        speed = row.simulated_s / max(row.cpu_s, 1e-9)
        shares = f"{f'{row.bddl}/{row.runs}':>8}{f'{row.ours}/{row.runs}':>8}{done:>9}"
        print(f"{name:<34}{shares}{len(row.false):>7}{len(row.differ):>8}{speed:>13.1f}")
    for name, row in measured.items():
        for words in (*row.false, *row.differ):
            print(f"{name}: {words}")
    runs, true = (sum(getattr(row, key) for row in measured.values()) for key in ("runs", "bddl"))
    differ = sum(len(row.differ) for row in measured.values())
    share = 100.0 * true / max(runs, 1)
    found = f"{share:.1f} % true by bddl; the verdicts differ on {differ}"
    print(f"{len(measured)} activities, {runs} runs: {found}")
    return 1 if differ or any(row.false for row in measured.values()) else 0


def _count(row: Row, seed: int, summary: dict[str, Any]) -> None:
    metrics = summary["metrics"]
    row.runs += 1
    row.simulated_s += summary["sim_time_s"]
    row.ends[summary["outcome"]] += 1
    row.bddl += bool(metrics["activity_bddl"])
    row.ours += bool(metrics["activity_ours"])
    row.false += [f"seed {seed}: {item}" for item in metrics["untrue"]]
    if not metrics.get("activity_agreed", False):
        ours, theirs = metrics["activity_ours_wrong"], metrics["activity_bddl_wrong"]
        row.differ.append(f"seed {seed}: ours: {ours or 'done'}; bddl: {theirs or 'done'}")


if __name__ == "__main__":
    main()
