"""Measure laying sensors with the arm moving while the base drives, against one after the other.

python -m benchmarks.field.deploying [--course straight|zigzag|short] [--way all|NAME]
                               [--runs N] [--first SEED] [--jobs N] [--raw CSV]

Whole tasks on the kinematic backend, nothing rendered or written. The time of a target is from the release
of the sensor before to its own. "together" rests for 2 s before the hand moves over the target, "0 s" not
at all: the shorter the rest, the fewer fixes are received. In each period all links, hand and sensor are
compared with wheels (with their steering), body and mast: "nearest" is the least distance, negative in
contact; "met" counts contacts with ground and rocks except for sensors being lowered. "short" has two
targets at random, for many runs of all that the arm does on the way. With --raw the rows of other seeds in
that file are kept and count too.
"""

from __future__ import annotations

import argparse
import csv
import math
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.field.placement_radius import share_radius
from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.permits import Permits
from handcart.networks.run_files.telemetry import Telemetry
from handcart.networks.runs.run import step_until_end
from handcart.networks.task.preparing import Prepared, prepare
from handcart.primitives.field.field import Field
from handcart.primitives.field.field_work import FieldWork
from handcart.primitives.motions.grip import hand_to_tips
from handcart.robotics.manipulation.motions.collision_model import HELD_NAME, CollisionModel

TASKS_FOLDER = Path(__file__).parent.parent.parent / "tasks"
LAYING_SETTINGS = {
    "together": {"together": "true", "settle_s": "2"},
    "together, 0 s": {"together": "true"},
    "sequential": {},
}
WHEELBASE_M = 0.6  # [m]
STEERING_STEP_RAD = 0.1  # [rad] between the steering angles that are looked at
MIN_WHEEL_MOTION_M = 1e-6  # [m] of the wheels in a period


class Laying(NamedTuple):
    """One sensor, a row of the raw file."""

    course: str
    way: str
    seed: int
    name: str
    x_mm: float
    """Off its target, by the ground truth."""
    y_mm: float
    let_go_s: float
    """Since the sensor before was; of the first, NaN."""
    nearest_mm: float
    """Least distance of all pairs of arm and robot in the whole run [mm]."""
    met: int
    """Contacts with something else in the whole run."""


class Watcher(RunObserver):
    """Holds the arm against its robot in each period of a run."""

    def __init__(self, robot: Robot, field: Field) -> None:
        self._scene: Any = robot.backend.scene  # type: ignore[attr-defined]
        self._held = field.held(hand_to_tips(robot), HELD_NAME)
        self._arm = robot.arm_model
        self._model = cache(self._make)
        self._last = (math.nan, b"")
        self._rolled = 0.0
        self.nearest = math.inf
        self.met = 0

    def period(self, robot: Robot) -> None:
        """Update after a period."""
        scene = self._scene
        speed, turn = robot.driven
        steering = round(math.atan(WHEELBASE_M * turn / speed) / STEERING_STEP_RAD) if speed else 0
        key = (steering, scene.joints.tobytes())
        if key != self._last:
            model = self._model(steering, scene.held is not None)
            self.nearest = min(self.nearest, model.distance(scene.joints))
            self._last = key
        rolled = sum(robot.base.wheel_travel())
        if abs(rolled - self._rolled) > MIN_WHEEL_MOTION_M:
            self.met += len(scene.touching)
        self._rolled = rolled

    def _make(self, steering: int, holds: bool) -> CollisionModel:
        angle, width = steering * STEERING_STEP_RAD, self._scene.width / 2.0
        turned = {"left_steering": angle, "right_steering": angle}
        arm = self._arm.with_others({"left_finger": width, "right_finger": width, **turned})
        return CollisionModel(arm, (), self._held if holds else None)


def one_run(job: tuple[str, str, int]) -> list[Laying]:
    """One run of a task."""
    course, way, seed = job
    with tempfile.TemporaryDirectory() as folder:
        settings = {**LAYING_SETTINGS[way], **COURSE_MAKERS[course](Path(folder), seed)}
        task = "straight" if course == "short" else course
        with prepare(TASKS_FOLDER / f"deploy_{task}" / "task.yaml", None, settings, seed) as prepared:
            return _laid(prepared, course, way, seed)


def _laid(prepared: Prepared, course: str, way: str, seed: int) -> list[Laying]:
    robot, model = prepared.robot, prepared.model
    field = model.of(FieldWork).field
    assert field is not None
    watcher = Watcher(robot, field)
    coordinator = Coordinator(prepared.task.network, robot, model, permission=Permits("always"))
    end = step_until_end(coordinator, robot, Telemetry(), [watcher])
    assert end.outcome == "Success", end.reason
    blocks = robot.backend.scene.of(FieldProps).sensors  # type: ignore[attr-defined]
    times = [math.nan, *(laid.time for laid in model.of(FieldWork).laid)]
    rows = []
    for number, laid in enumerate(model.of(FieldWork).laid):
        target = model.of(FieldWork).targets[laid.name]
        lies = min((b.pose[:2, 3] for b in blocks.values()), key=lambda p: math.dist(p, (laid.x, laid.y)))
        off = 1e3 * (lies - (target.x, target.y))
        took = times[number + 1] - times[number]
        near = 1e3 * watcher.nearest
        rows.append(Laying(course, way, seed, laid.name, off[0], off[1], took, near, watcher.met))
    return rows


def _short(folder: Path, seed: int) -> dict[str, str]:
    """Two targets ahead, on a bent way."""
    rng = np.random.default_rng(seed)
    place, heading, lines = np.zeros(2), 0.0, ["name,x_m,y_m"]
    for name in ("first", "second"):
        heading += float(rng.uniform(-0.7, 0.7))
        place = place + rng.uniform(6.0, 9.0) * np.array([math.cos(heading), math.sin(heading)])
        lines.append(f"{name},{place[0]:.3f},{place[1]:.3f}")
    path = folder / "targets.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return {"targets": str(path), "wait_s": "10"}


COURSE_MAKERS: dict[str, Callable[[Path, int], dict[str, str]]] = {
    "straight": lambda folder, seed: {},
    "zigzag": lambda folder, seed: {},
    "short": _short,
}


def in_words(rows: list[Laying]) -> str:
    """Return a line of the table."""
    runs: dict[int, list[Laying]] = {}
    for row in rows:
        runs.setdefault(row.seed, []).append(row)
    errors = [np.array([(row.x_mm, row.y_mm) for row in run]) / 1e3 for run in runs.values()]
    took = np.array([row.let_go_s for row in rows])
    found = share_radius(errors, 0.95)
    radius = (
        "too few"
        if found is None
        else f"{1e3 * found.radius:.0f} [{1e3 * found.low:.0f}-{1e3 * found.high:.0f}]"
    )
    nearest, met = min(row.nearest_mm for row in rows), sum(run[0].met for run in runs.values())
    contacts = sum(run[0].nearest_mm <= 0.0 for run in runs.values())
    return (
        f"{rows[0].course:9}{rows[0].way:14}{len(runs):5}{len(rows):7}{np.nanmean(took):9.1f}"
        f"{radius:>16}{contacts:10}{nearest:9.1f}{met:5}"
    )


def _read(path: Path | None) -> list[Laying]:
    if path is None or not path.exists():
        return []
    with path.open(encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    return [
        Laying(course, way, int(seed), name, float(x), float(y), float(let_go), float(nearest), int(met))
        for course, way, seed, name, x, y, let_go, nearest, met in rows
    ]


def _write(path: Path, rows: list[Laying]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(Laying._fields)
        writer.writerows([*row[:4], *(f"{figure:.3f}" for figure in row[4:8]), row.met] for row in rows)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--course", choices=COURSE_MAKERS, default="straight")
    parser.add_argument("--way", choices=["all", *LAYING_SETTINGS], default="all")
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--raw", type=Path)
    given = parser.parse_args()
    ways = list(LAYING_SETTINGS) if given.way == "all" else [given.way]
    rows = _read(given.raw)
    have = {row[:3] for row in rows}
    seeds = range(given.first, given.first + given.runs)
    jobs = [(given.course, way, seed) for seed in seeds for way in ways]
    with ProcessPoolExecutor(given.jobs, get_context("spawn")) as pool:
        for found in pool.map(one_run, [job for job in jobs if job not in have]):
            rows += found
    if given.raw is not None:
        _write(given.raw, rows)
    print("course   way            runs  laid  s/target    r95 true [mm]  contacts  nearest  met")
    for course, way in sorted({row[:2] for row in rows}):
        print(in_words([row for row in rows if row[:2] == (course, way)]))


if __name__ == "__main__":
    main()
