"""Halls of posts that no map shows: `python -m benchmarks.driving.cluttered [--worlds N] [--speed 1|2]`.

A cellular automaton sets posts into a hall of 14 x 4.8 m, at three densities; start and goal are 10 m apart,
and a way with 5 cm beside the footprint (a disc, or a rectangle) leads through. `tasks/drive_map` drives
there, as `handcart run` does it. The map shows the walls (`walls`), walls and every other post (`half`),
nothing (`empty`), or everything (`all`). A world counts as reached if the goal was reached without a Fail.
Contacts and false outcomes are those of the simulated world. The time is that to the docked pose, over the
length of the best way on a map of everything, driven at top speed. `--shape` has a dead end or a closed wall
instead. Status 1 if a contact or a false outcome happened.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.cut_off import CutOff
from benchmarks.driving.cluttered_robot import write_robot
from benchmarks.driving.worlds.cluttered_worlds import (
    DENSITIES,
    Box,
    World,
    closed_wall,
    dead_end,
    make_world,
    walls,
    write_world,
)
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.footprint_spec import FootprintSpec
from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.body.base_contact import base_gap
from handcart.evaluation.judging.judge import Judge
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared, prepare
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2

TASK_PATH = Path(__file__).resolve().parents[2] / "tasks" / "drive_map" / "task.yaml"
EXACT, ROUGH = (40.0, 1.0), (1500.0, 10.0)  # tolerances of the goal in [mm] and [deg]
GIVEN_S = 180.0  # simulated time after which a run is interrupted
SLOW_MS = 10.0  # CPU of a period that is counted as slow


@dataclass
class Trial:
    """Result of one world."""

    seed: int
    density: float
    outcome: str = ""
    reason: str = ""
    fails: int = 0
    seconds: float = math.nan
    """Time at which MOVE_TO ended with Success, in [s]."""
    best_m: float = math.nan
    contacts: int = 0
    false: list[str] = field(default_factory=list)
    nearest_mm: float = math.inf
    """Least distance between the footprint and anything."""
    off_mm: float = math.nan
    """Error of the estimated pose at the end."""
    off_sigmas: float = math.nan
    """Distance from the goal in standard deviations of the claimed covariance."""
    sigma_mm: float = math.nan
    periods_ms: list[float] = field(default_factory=list)
    """CPU of each period without that of the simulation."""
    track: list[Pose2] = field(default_factory=list)
    given_s: float = GIVEN_S
    """Simulated time after which the run is interrupted, in [s]."""

    @property
    def reached(self) -> bool:
        """True if the goal was reached without a Fail."""
        return self.outcome == "Success" and self.fails == 0


class Watch(RunObserver):
    """Records the ground truth and the CPU time of a run."""

    def __init__(self, scene: Any, backend: Any, result: Trial) -> None:
        self._scene, self._result = scene, result
        self._simulated, self._since = 0.0, math.nan
        self._without(backend, "step")
        self._without(backend.get(RangeSensor), "scan")

    def _without(self, thing: Any, name: str) -> None:
        """Leave a method's time out of the periods'.

        Only its first call at an instant is timed, because reading the clock takes longer than the others.
        """
        original: Callable[[], Any] = getattr(thing, name)
        timed_at = math.nan

        def timed() -> Any:
            nonlocal timed_at
            if self._scene.time == timed_at:
                return original()
            timed_at, begun = self._scene.time, time.process_time()
            found = original()
            self._simulated += time.process_time() - begun
            return found

        setattr(thing, name, timed)

    def period(self, robot: Robot) -> None:
        now = time.process_time()
        if math.isfinite(self._since):
            self._result.periods_ms.append(1e3 * (now - self._since - self._simulated))
        scene, result = self._scene, self._result
        result.nearest_mm = min(result.nearest_mm, 1e3 * base_gap(scene, scene.base)[0])
        result.track.append(scene.base)
        if robot.time > self._result.given_s:
            raise TimeoutError
        self._simulated, self._since = 0.0, time.process_time()

    def event(self, event: Event) -> None:
        if isinstance(event, Ended) and event.primitive.label() == "MOVE_TO":
            if isinstance(event.outcome, Success):
                self._result.seconds = self._scene.time
            else:
                self._result.reason = f"{event.outcome}"[:300]


def try_world(world: World, chosen: argparse.Namespace) -> Trial:
    """Drive through a world."""
    result = Trial(world.seed, world.density, best_m=world.best.length)
    with TemporaryDirectory(prefix="cluttered-") as name:
        folder = Path(name)
        rough = chosen.localizer != "scan" or chosen.map == "empty"
        tolerance = ROUGH if rough else EXACT
        write_world(world, folder, _mapped(world, chosen.map), chosen.cell, tolerance)
        settings = {key: str(folder / f"{key}.yaml") for key in ("map", "world", "places")}
        settings |= {"robot": str(_robot(folder, chosen))}
        settings |= {"tour": "[goal]", "wait_s": "2"}
        with prepare(TASK_PATH, backend=chosen.backend, settings=settings, seed=world.seed) as prepared:
            run_watched(prepared, folder, result)
            scene = prepared.backend.scene  # type: ignore[attr-defined]
            result.contacts = len(scene.contacts)
            _compare(prepared.robot, scene.base, result)
    return result


def run_watched(prepared: Prepared, folder: Path, result: Trial) -> Judge:
    """Run a task below a folder, write its end and its false outcomes into `result`, and return the judge.

    A signal to end stops the run, and raises KeyboardInterrupt after it: the row of trials ends with it.
    """
    scene = prepared.backend.scene  # type: ignore[attr-defined]
    judge, watch = Judge(prepared), Watch(scene, prepared.backend, result)
    try:
        with Interrupts() as heard:
            options = RunOptions(observers=(watch, judge), interrupts=heard)
            done = execute(prepared, folder / "run", options)
        if heard.came:
            raise KeyboardInterrupt
        result.outcome, result.fails = str(done.summary["outcome"]), int(done.summary["fails"])
        result.reason = result.reason or str(done.summary["reason"])[:300]
    except TimeoutError:
        result.outcome = "out of time"
        result.reason = result.reason or f"after {result.given_s:g} s"
    result.false = list(judge.untrue)
    return judge


def _robot(folder: Path, chosen: argparse.Namespace) -> Path:
    return write_robot(folder, chosen.sides, chosen.speed, chosen.localizer, chosen.view)


def _compare(robot: Robot, truth: Pose2, result: Trial) -> None:
    """Compare the estimated pose with the true one."""
    off = np.array([robot.pose.x - truth.x, robot.pose.y - truth.y])
    spread = robot.localization.covariance[:2, :2] + 1e-8 * np.eye(2)
    result.off_mm = 1e3 * float(np.hypot(*off))
    result.off_sigmas = math.sqrt(float(off @ np.linalg.solve(spread, off)))
    result.sigma_mm = 1e3 * math.sqrt(float(np.linalg.eigvalsh(spread)[-1]))


def _mapped(world: World, shown: str) -> list[Box]:
    posts = {"walls": [], "empty": [], "half": world.posts[::2], "all": world.posts}[shown]
    return [] if shown == "empty" else [*walls(), *posts]


def report(results: list[Trial], speed: float) -> str:
    """Return the table of all worlds as text."""
    reached = [result for result in results if result.reached]
    ends = Counter(result.outcome for result in results)
    false, contacts = sum(len(result.false) for result in results), sum(result.contacts for result in results)
    lines = [
        f"{len(results)} worlds: {len(reached)} reached without a Fail "
        f"({100.0 * len(reached) / max(1, len(results)):.1f} %); false outcomes {false}; contacts {contacts}",
        f"ends: {', '.join(f'{count} {end}' for end, count in ends.most_common())}; "
        f"Fails on the way {sum(result.fails for result in results)}",
    ]
    if reached:
        ratios = np.array([trial.seconds * speed / trial.best_m for trial in reached])
        low, middle, high = np.percentile(ratios, [5, 50, 95])
        lines.append(
            f"time over (best way / top speed): median {middle:.2f} (5 % {low:.2f}, 95 % {high:.2f})"
        )
    off, sigmas = (np.array([getattr(e, key) for e in results]) for key in ("off_mm", "off_sigmas"))
    lines.append(
        f"pose error at the end: median {np.median(off):.0f} mm, most {off.max():.0f} mm; "
        f"beyond 3 sigma in {int((sigmas > 3.0).sum())} worlds; median sigma "
        f"{np.median([result.sigma_mm for result in results]):.0f} mm"
    )
    lines.append(f"nearest to anything: {min(result.nearest_mm for result in results):.1f} mm")
    taken = np.concatenate([result.periods_ms for result in results])
    if not len(taken):
        return "\n".join([*lines, "no period was measured: the runs ended before they drove"])
    lines.append(
        f"CPU of a period: mean {taken.mean():.2f} ms, 99 % {np.percentile(taken, 99):.2f} ms, "
        f"above {SLOW_MS:g} ms {100.0 * float((taken > SLOW_MS).mean()):.2f} %"
    )
    for density in sorted({result.density for result in results}):
        part = [result for result in results if result.density == density]
        lines.append(f"  density {density:g}: {sum(e.reached for e in part)} of {len(part)} reached")
    return "\n".join(lines)


def draw(world: World, result: Trial, shape: Footprint, path: Path) -> None:
    """Draw a world, its best way and the true track."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    axes = (figure := Figure(figsize=(14, 5))).add_subplot()
    for x, y, _, length, width in [*walls(), *world.posts]:
        axes.add_patch(Rectangle((x - length / 2, y - width / 2), length, width, color="0.4"))
    axes.plot(*world.best.points.T, "g:", linewidth=1.0)
    axes.plot(*np.array(result.track)[:, :2].T, "b-", linewidth=1.0)
    for base in [*result.track[::20], result.track[-1]]:
        axes.plot(*shape.outline(*base).T, "b-", linewidth=0.3)
    axes.plot(*shape.outline(*result.track[-1]).T, "b-", linewidth=1.0)
    axes.set_aspect("equal")
    axes.set_title(f"{result.seed}, density {result.density:g}: {result.outcome}, {result.seconds:.1f} s")
    figure.savefig(path, dpi=80)


def shape_of(sides: tuple[float, ...]) -> Footprint:
    """Return the footprint with a radius, or with length and width, in [m]."""
    if len(sides) == 1:
        return Footprint(sides[0])
    return FootprintSpec(rectangle_m=(sides[0], sides[1])).shape


def worlds_of(chosen: argparse.Namespace) -> list[Callable[[], World]]:
    """Return makers of the chosen worlds, densities in turn."""
    seeds = range(chosen.first, chosen.first + chosen.worlds)
    if chosen.shape != "posts":
        boxes = dead_end() if chosen.shape == "dead_end" else closed_wall()
        best = make_world(0, 0.0, chosen.shape_of_robot).best
        return [lambda seed=seed: World(seed, 0.0, boxes, best) for seed in seeds]  # type: ignore[misc]
    densities = DENSITIES if chosen.density is None else (chosen.density,)
    return [
        lambda seed=seed: make_world(seed, densities[seed % len(densities)], chosen.shape_of_robot)  # type: ignore[misc]
        for seed in seeds
    ]


def main() -> None:
    """Try the worlds one after the other."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--worlds", type=int, default=300, help="number of worlds (default: 300)")
    words.add_argument("--first", type=int, default=0, metavar="SEED", help="seed of the first (default: 0)")
    words.add_argument("--speed", type=float, default=2.0, help="top speed in m/s (default: 2)")
    words.add_argument("--density", type=float, help="share of posts (default: three in turn)")
    words.add_argument("--map", choices=("walls", "half", "empty", "all"), default="walls")
    words.add_argument("--shape", choices=("posts", "dead_end", "closed_wall"), default="posts")
    words.add_argument("--localizer", choices=("scan", "odometry"), default="scan")
    words.add_argument(
        "--footprint",
        default="0.22",
        help="radius of a disc in m, or length and width, such as 0.5x0.43 (default: 0.22)",
    )
    words.add_argument("--view", type=float, default=360.0, help="of the lidar, in deg (default: 360)")
    words.add_argument("--cell", type=float, default=0.05, help="of the map, in m (default: 0.05)")
    words.add_argument("--backend", default="kinematic", help="kinematic (default), mujoco, pybullet")
    words.add_argument("--pictures", type=Path, help="existing folder for a picture of each world")
    chosen = words.parse_args()
    chosen.sides = tuple(float(side) for side in chosen.footprint.split("x"))
    chosen.shape_of_robot = shape_of(chosen.sides)
    print(f"{chosen.worlds} worlds on {chosen.backend}, {chosen.speed:g} m/s, map: {chosen.map}", flush=True)
    results = []
    with CutOff() as cut:  # report the runs until then
        for make in worlds_of(chosen):
            world = make()
            result = try_world(world, chosen)
            results.append(result)
            print(
                f"world {result.seed} ({result.density:g}): {result.outcome}, {result.fails} Fails, "
                f"{result.seconds:.1f} s for {result.best_m:.1f} m, {result.contacts} contacts, nearest "
                f"{result.nearest_mm:.0f} mm, off {result.off_mm:.0f} mm ({result.off_sigmas:.1f} sigma)"
                + ("" if result.reached else f"; {result.reason}")
                + "".join(f"\n  FALSE: {item}" for item in result.false),
                flush=True,
            )
            if chosen.pictures:
                draw(world, result, chosen.shape_of_robot, chosen.pictures / f"world_{result.seed}.png")
    print(report(results, chosen.speed))
    raise SystemExit(cut.status(not results or any(item.contacts or item.false for item in results)))


if __name__ == "__main__":
    main()
