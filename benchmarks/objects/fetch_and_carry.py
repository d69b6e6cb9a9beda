"""Fetch a parcel with a tag from one table to another: `python -m benchmarks.objects.fetch_and_carry`.

`tasks/fetch_and_carry` is run with each seed, as `handcart run` does it. The parcel is off its believed place
by a standard deviation of 40 mm and 30 degrees; with every other seed a crate that no map shows stands about
on the way between the tables, elsewhere with each seed. The parcel goes to the spot `left`, the spot `right`,
or any free spot, by turns. With `--moved-mm` and `--moved-deg`, somebody has moved both tables with what is
on them, by so much, in a direction drawn by the seed; the robot does not know. Printed are the Successes,
the outcomes that the ground truth contradicts, and the error of PLACE: of the parcel from its named spot (on
the true table), and of where it was seen to stand. A robot whose package isn't installed is skipped. Status 1
if an outcome was false.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import yaml

from handcart.evaluation.trials.running import run_task
from handcart.files.errors import InputError
from handcart.networks.runs.run_options import RunOptions
from handcart.robotics.geometry.pose2 import Pose2

TASK_FOLDER = Path(__file__).resolve().parents[2] / "tasks" / "fetch_and_carry"
SPOT_NAMES = ("left", "right", None)
CARRY_LEG_M = ((2.2, 3.0), (4.3, 2.0))  # from the place at table A to that at table B [m]


class TableMove(NamedTuple):
    """Size of the motion of each table since the robot's files were written."""

    distance: float = 0.0
    """[m]"""
    turn: float = 0.0
    """[rad], to either side"""


NOT_MOVED = TableMove()

RunOnce = Callable[[Path, str, str, int], dict[str, Any]]
"""Runs a task below a folder, on a backend, with a robot and a seed; returns its summary."""


@dataclass
class Figures:
    """Results of some runs."""

    runs: int
    ends: Counter[str]
    false: list[str]
    placed_mm: list[float]
    seen_mm: list[float]
    simulated_s: float
    cpu_s: float
    contacts: list[str] = field(default_factory=list)
    """Contacts that no primitive intended, in runs with any end."""


def main() -> None:
    """Print a row for each robot and backend."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seeds", type=int, default=20, help="number of seeds, from --first")
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--backends", nargs="+", default=["kinematic", "mujoco"])
    words.add_argument(
        "--robots", "--robot", nargs="+", default=["librarian"], help="names or files of robots"
    )
    words.add_argument("--moved-mm", type=float, default=0.0, help="distance by which tables were moved")
    words.add_argument("--moved-deg", type=float, default=0.0, help="angle by which tables were turned")
    asked = words.parse_args()
    run = partial(run_once, moved=TableMove(asked.moved_mm / 1e3, math.radians(asked.moved_deg)))
    seeds = range(asked.first, asked.first + asked.seeds)
    rows: dict[tuple[str, str], Figures | str] = {}
    for robot in asked.robots:
        for backend in asked.backends:
            try:
                rows[robot, backend] = measure(backend, robot, seeds, run)
            except InputError as error:  # its package isn't installed, or it reaches no table
                rows[robot, backend] = f"skipped: {error}"
    sys.exit(print_rows(rows))


def print_rows(rows: Mapping[tuple[str, str], Figures | str]) -> int:
    """Print a row for each robot and backend, false outcomes and contacts; return 1 if any is there."""
    wide = max(len(robot) for robot, _ in rows)
    print(
        f"{'robot':<{wide}}  {'backend':<11}{'Success':>9}{'false':>7}{'contacts':>10}",
        f"{'PLACE off its spot, 50/95 %':>29}",
        end="",
    )
    print(f"{'seen off, 50/95 %':>20}{'CPU: times real time':>22}  other ends")
    for (robot, backend), found in rows.items():
        print(f"{robot:<{wide}}  {backend:<11}", end="")
        if isinstance(found, str):
            print(f"  {found}")
            continue
        success = f"{found.ends['Success']}/{found.runs}"
        print(
            f"{success:>9}{len(found.false):>7}{len(found.contacts):>10}{_spread(found.placed_mm):>30}",
            end="",
        )
        speed = found.simulated_s / found.cpu_s
        print(f"{_spread(found.seen_mm):>20}{speed:>22.1f}  {_others(found.ends)}")
    measured = {key: found for key, found in rows.items() if isinstance(found, Figures)}
    for (robot, backend), found in measured.items():
        for wrong in (*found.false, *found.contacts):
            print(f"{robot} {backend}: {wrong}")
    return 1 if any(found.false or found.contacts for found in measured.values()) else 0


def measure(backend: str, robot: str, seeds: range, run: RunOnce | None = None) -> Figures:
    """Run the task, or another one, with some seeds on a backend."""
    run = run or run_once
    found = Figures(0, Counter(), [], [], [], 0.0, 0.0)
    for seed in seeds:
        begun = time.process_time()
        with TemporaryDirectory(prefix="fetch-") as folder:
            summary = run(Path(folder), backend, robot, seed)
        metrics = summary["metrics"]
        found.runs += 1
        found.cpu_s += time.process_time() - begun
        found.simulated_s += summary["sim_time_s"]
        found.ends[summary["outcome"] if not summary["reason"] else summary["reason"][:80]] += 1
        found.false += [f"seed {seed}: {item}" for item in metrics["untrue"]]
        found.contacts += [f"seed {seed}: {_contact(item)}" for item in metrics["contacts"]]
        if "placed_off_mm" in metrics:
            found.placed_mm.append(metrics["placed_off_mm"])
        if "placed_seen_off_mm" in metrics:
            found.seen_mm.append(metrics["placed_seen_off_mm"])
        print(
            f"{robot} {backend} seed {seed}: {summary['outcome']} {summary['reason']}",
            file=sys.stderr,
            flush=True,
        )
    return found


def _contact(item: Mapping[str, Any]) -> str:
    return f"{item['body']} touched {item['other']} in {item['do'] or 'a pause'}, at {item['from_s']:.1f} s"


def run_once(
    folder: Path, backend: str, robot: str, seed: int, moved: TableMove = NOT_MOVED
) -> dict[str, Any]:
    """Run the task once below a folder; return its summary."""
    spot = SPOT_NAMES[seed % len(SPOT_NAMES)]
    settings = {"robot": robot, "world": str(write_world(folder, seed, moved)), "spot": spot or "null"}
    options = RunOptions(backend=backend, settings=settings, seed=seed)
    summary, _ = run_task(TASK_FOLDER / "task.yaml", folder, options)
    return summary


def write_world(folder: Path, seed: int, moved: TableMove = NOT_MOVED) -> Path:
    """Write the task's world; with odd seeds with a crate on the way between the tables."""
    text = (TASK_FOLDER / "world.yaml").read_text(encoding="utf-8")
    if any(moved):
        text = _with_moved_tables(text, moved, np.random.default_rng((seed, 1)))
    if seed % 2:
        rng = np.random.default_rng(seed)
        along, aside, turn = rng.uniform(0.35, 0.65), rng.uniform(-0.25, 0.25), rng.uniform(0.0, 90.0)
        (x, y), (ex, ey) = CARRY_LEG_M
        length = math.hypot(ex - x, ey - y)
        x, y = (
            x + along * (ex - x) - aside * (ey - y) / length,
            y + along * (ey - y) + aside * (ex - x) / length,
        )
        crate = (
            f"{{name: crate, x_m: {x:.3f}, y_m: {y:.3f}, heading_deg: {turn:.0f}, size_m: [0.4, 0.3, 0.4]}}"
        )
        text += f"surprises:\n  - {crate}\n"
    path = folder / "world.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def _with_moved_tables(text: str, moved: TableMove, rng: np.random.Generator) -> str:
    """Return a world with each table moved, and what is on it along with it."""
    world = yaml.safe_load(text)
    for table in world["furniture"]:
        way, side = rng.uniform(0.0, 2.0 * math.pi), rng.choice([-1.0, 1.0])
        before = Pose2(table["x_m"], table["y_m"], 0.0)
        step = moved.distance * math.cos(way), moved.distance * math.sin(way)
        now = Pose2(before.x + step[0], before.y + step[1], float(side * moved.turn))
        half = np.array(table["size_m"][:2]) / 2
        on_it = [
            object_
            for object_ in world["objects"]
            if (np.abs((object_["x_m"] - before.x, object_["y_m"] - before.y)) < half).all()
        ]
        for item in (table, *on_it):
            heading = math.radians(item.get("heading_deg", 0.0))
            pose = now.compose(Pose2(item["x_m"], item["y_m"], heading).relative_to(before))
            item |= {"x_m": pose.x, "y_m": pose.y, "heading_deg": math.degrees(pose.theta)}
    return str(yaml.safe_dump(world, sort_keys=False))


def _spread(values: list[float]) -> str:
    if not values:
        return "-"
    middle, high = np.percentile(values, [50.0, 95.0])
    return f"{middle:.1f} / {high:.1f} mm"


def _others(ends: Counter[str]) -> str:
    return "; ".join(f"{count} x {end}" for end, count in ends.items() if end != "Success")


if __name__ == "__main__":
    main()
