"""Drive other people's robots: `python -m benchmarks.robots.foreign PACKAGES [--seeds N]`.

PACKAGES is a folder into which packages of PyPI were installed, each alone or all together:
`pip install --no-deps --target PACKAGES/NAME NAME` for example-robot-data, hello-robot-stretch-urdf and
pybullet. A robot whose package isn't there is skipped, and the table says why. For each robot its files are
copied, `handcart check --draft` writes a robot's file from the maker's URDF, the overlay in `foreign_robots`
is merged into it (what a user measures or chooses), `handcart check` reads the result, and
`tasks/drive_map` drives it to five places, for each backend and seed. The last line counts over all robots
that are there. Exit status 1 where a place was not reached, something was touched, or an outcome was false.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import re
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from rich.console import Console
from rich.table import Table

from benchmarks.robots.five_places import PLACE_POSES, write_room
from benchmarks.robots.foreign_robots import FOREIGN_ROBOTS, LIDAR_URDF, ForeignRobot, NotThere
from handcart.evaluation.trials.running import run_task
from handcart.files.errors import InputError
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "drive_map" / "task.yaml"


class Driven(NamedTuple):
    """One run of a robot."""

    reached: int
    """Places, of five."""
    contacts: int
    false: int
    """Outcomes that the ground truth contradicts."""
    why: Sequence[str]
    """Reported reasons of places that were not reached."""


class Tally(RunObserver):
    """Counts places and contacts, and keeps what was reported."""

    def __init__(self) -> None:
        self.reached: set[str] = set()
        self.why: list[str] = []

    def event(self, event: Event) -> None:
        if isinstance(event, Ended) and isinstance(event.primitive, MoveTo):
            if isinstance(event.outcome, Success):
                self.reached.add(str(event.primitive.place))
            else:
                self.why.append(f"{event.primitive.place}: {event.outcome.reason}")


def draft(robot: ForeignRobot, packages: Path, folder: Path) -> Path:
    """Write a robot's file: the draft of its URDF with the robot's overlay.

    Raises:
        NotThere: the package isn't installed there.
        InputError: the URDF or the robot's file is refused.
    """
    from handcart.tools.checks.check_urdf import urdf_facts

    urdf = robot.collect(packages, folder)
    (folder / "lidar.urdf").write_text(LIDAR_URDF, encoding="utf-8")
    drafted = folder / "robot.yaml"
    urdf_facts(urdf, draft=drafted)
    content = merged(yaml.safe_load(drafted.read_text(encoding="utf-8")), robot.overlay)
    drafted.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return drafted


def merged(content: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping with another one laid over it, key by key; None removes a key."""
    result = dict(content)
    for key, value in overlay.items():
        old = result.get(key)
        result[key] = merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return {key: value for key, value in result.items() if value is not None}


def drive(file: Path, folder: Path, backend: str, seed: int) -> Driven:
    """Drive a robot to the five places."""
    tally = Tally()
    settings = {**write_room(folder), "robot": str(file)}
    options = RunOptions(backend=backend, settings=settings, seed=seed, observers=(tally,))
    with contextlib.redirect_stderr(io.StringIO()):  # a line for each action
        summary, _ = run_task(TASK_FILE, folder / "runs", options)
    metrics = summary["metrics"]
    contacts, false = len(metrics["contacts"]), len(metrics["untrue"])
    why = tally.why or ([] if len(tally.reached) == len(PLACE_POSES) else [str(summary["reason"])])
    return Driven(len(tally.reached), contacts, false, [*why, *map(str, metrics["untrue"])])


def tried(robot: ForeignRobot, packages: Path, chosen: argparse.Namespace, say: Console) -> list[list[str]]:
    """Return the rows of the table for one robot."""
    from handcart.tools.checks.check_robot import robot_facts

    rows = []
    with tempfile.TemporaryDirectory(prefix="foreign-") as name:
        folder = Path(name)
        try:
            file = draft(robot, packages, folder)
            warnings = len(robot_facts(file, None, quick=True)["warnings"])
        except NotThere as error:
            return [[robot.name, "", "skipped", f"{error}; pip install {robot.package}"]]
        except InputError as error:
            return [[robot.name, "check", "refused", str(error).replace(name, "")]]
        for backend in chosen.backends:
            runs, begun = [], time.process_time()
            for seed in range(chosen.seed, chosen.seed + chosen.seeds):
                runs.append(drive(file, folder, backend, seed))
                say.print(
                    f"{robot.name} {backend} seed {seed}: {runs[-1].reached} of {len(PLACE_POSES)} places"
                )
            rows.append(_row(robot, backend, runs, warnings, time.process_time() - begun))
    return rows


def _row(robot: ForeignRobot, backend: str, runs: Sequence[Driven], warnings: int, cpu: float) -> list[str]:
    reached, asked = sum(driven.reached for driven in runs), len(PLACE_POSES) * len(runs)
    words = f"{reached} of {asked} places, {sum(e.contacts for e in runs)} contacts"
    words += f", {sum(e.false for e in runs)} false outcomes"
    why = sorted({item for run in runs for item in run.why})
    return [
        robot.name,
        backend,
        words,
        f"{warnings} warnings of check, {cpu:.0f} CPU s; {' | '.join(why[:3])}",
    ]


def sum_line(rows: Sequence[Sequence[str]]) -> str:
    """Return the sum over the table's rows: places, share, contacts, false outcomes, robots not driven."""
    driven = [tuple(map(int, re.findall(r"\d+", row[2]))) for row in rows if row[2].endswith("outcomes")]
    reached, asked, contacts, false = map(sum, zip(*driven, strict=True)) if driven else (0, 0, 0, 0)
    left = ", ".join(f"{row[0]} {row[2]}" for row in rows if not row[2].endswith("outcomes"))
    return (
        f"places reached: {reached} of {asked} ({100.0 * reached / max(1, asked):.1f} %); "
        f"contacts: {contacts}; false outcomes: {false}{left and f'; not driven: {left}'}"
    )


def main() -> None:
    """Print a table; status 1 where something went wrong."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [foreign_robot.name for foreign_robot in FOREIGN_ROBOTS]
    words.add_argument("packages", type=Path, help="folder with installed packages")
    words.add_argument("--robots", nargs="+", default=names, choices=names, metavar="NAME")
    words.add_argument("--backends", nargs="+", default=["kinematic", "mujoco"], metavar="NAME")
    words.add_argument("--seeds", type=int, default=5, help="how many")
    words.add_argument("--seed", type=int, default=0, help="the first")
    chosen = words.parse_args()
    say, table = Console(stderr=True), Table("robot", "backend", "result", "notes", box=None)
    rows = []
    for robot in FOREIGN_ROBOTS:
        if robot.name in chosen.robots:
            say.print(f"{robot.name} ...")
            rows += tried(robot, chosen.packages, chosen, say)
    for row in rows:
        table.add_row(*row)
    Console().print(table)
    print(sum_line(rows))
    places = len(PLACE_POSES) * chosen.seeds
    whole = f"{places} of {places} places, 0 contacts, 0 false outcomes"
    sys.exit(0 if all(row[2] in (whole, "skipped") for row in rows) else 1)


if __name__ == "__main__":
    main()
