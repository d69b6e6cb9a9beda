"""Places as near to walls as `check` allows: python -m benchmarks.driving.near_walls [--worlds N] [--jobs N]

Random rooms with an inner wall, a door in it, boxes on the map (low ones too, which no scan shows) and, in
every fifth world, boxes that aren't on it; cells of 0.05 to 0.25 m; footprints of 0.2 to 0.53 m. Places are
put beside what is occupied, by distances worked out here, cell by cell: as near as `check` allows, and
nearer. What `handcart check` says of them is held against that; those that it calls reachable are driven to
by `tasks/drive_map`, as `handcart run` does it, on the kinematic backend with the robot's own errors.
Contacts are the simulated world's own. With --nearer places aren't checked: each that is too near is tried by
MOVE_TO itself, as `handcart do` does it. Ended by Ctrl-C or SIGTERM, it reports on the worlds tried so far.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import Progress

from benchmarks.cut_off import CutOff, each_result
from handcart.robotics.numerics.arrays import FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.driving.worlds.random_room import Body, Room, write, write_places
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import check, prepare
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "drive_map" / "task.yaml"
NEAR, TOO_NEAR = 6, 2
MIN_TOLERANCE_MM = 40.0  # of a place; on coarse cells as much as a cell, which walls on one side leave open


class Stood(NamedTuple):
    """Result of one place, by the ground truth."""

    name: str
    reached: bool
    reason: str
    off_mm: float
    lost_mm: float


@dataclass
class Trial:
    """Result of one world."""

    seed: int
    cell: float
    body: Body
    surprised: bool
    places: int = 0
    allowed: int = 0
    wrongly: list[str] = field(default_factory=list)
    """What `check` said of a place that isn't so."""
    stood: list[Stood] = field(default_factory=list)
    contacts: list[str] = field(default_factory=list)
    nearest_mm: float = math.inf
    """Between the footprint and anything, at any time."""
    seconds: float = 0.0


class Eye(RunObserver):
    """Takes the ground truth down."""

    def __init__(self, scene: Any, robot: Robot, places: Any, result: Trial) -> None:
        self._scene, self._robot, self._places, self._result = scene, robot, places, result

    def period(self, robot: Robot) -> None:
        scene = self._scene
        room = scene.body_plan.clearance(scene.base.x, scene.base.y, scene.time)[0]
        self._result.nearest_mm = min(self._result.nearest_mm, 1e3 * (room - robot.spec.footprint_radius_m))

    def event(self, event: Event) -> None:
        if not isinstance(event, Ended) or not isinstance(event.primitive, MoveTo):
            return
        reached, name = isinstance(event.outcome, Success), event.primitive.place
        off = 1e3 * self._scene.base.distance(self._places[name].pose)
        lost = 1e3 * self._scene.base.distance(self._robot.pose)
        self._result.stood.append(Stood(name, reached, getattr(event.outcome, "reason", ""), off, lost))

    def end(self) -> None:
        self._result.contacts += [f"{c.time:.2f} s: {c.body} and {c.other}" for c in self._scene.contacts]


def try_world(seed: int, nearer: bool) -> Trial:
    """Make a world, run `check` on its places, and drive to the allowed ones."""
    begun, room = time.process_time(), Room(seed)
    result = Trial(seed, room.cell, room.body, bool(room.surprises))
    with TemporaryDirectory(prefix="near-walls-") as name:
        folder = Path(name)
        settings = write(room, folder, room.start())
        home = check(TASK_FILE, settings=settings).places[0]
        assert home.way.component is not None, seed
        places = _places(room, folder, settings, result)
        if nearer:
            _try_nearer(room, folder, settings, result)
        elif places:
            _drive(folder, settings, places, result)
    result.seconds = time.process_time() - begun
    return result


def _places(room: Room, folder: Path, settings: dict[str, str], result: Trial) -> list[str]:
    """Put places beside things; which of them `check` allows and calls reachable."""
    own, own_place = (folder / "places.yaml").read_text(), _home(folder)[:2]
    wanted: dict[str, tuple[float, float, float]] = {}
    least = room.least
    allowed, refused = room.beside(least + 1e-6), room.beside(least - 0.001)
    for number in range(NEAR):
        wanted[f"near_{number}"] = (*next(allowed), room.rng.uniform(-180.0, 180.0))
    for number in range(TOO_NEAR):
        wanted[f"too_near_{number}"] = (*next(refused), room.rng.uniform(-180.0, 180.0))
    result.places = NEAR
    tolerance_mm = max(MIN_TOLERANCE_MM, 1e3 * room.cell)
    write_places(folder, wanted, tolerance_mm)
    (folder / "places.yaml").write_text(own + (folder / "places.yaml").read_text().split("places:\n")[1])
    checked = check(TASK_FILE, settings=settings)
    found = {place.name: place for place in checked.places}
    refused_names = {re.findall(r"place '(\w+)'", error.message)[0] for error in checked.errors}
    for text in wanted:
        way = found[text].way
        if way.fits == text.startswith("too_near") or (way.route is None) != (text in refused_names):
            result.wrongly.append(f"{text}: {found[text].words()}")
    kept = [text for text in wanted if found[text].way.route is not None]
    write_places(folder, {text: wanted[text] for text in kept}, tolerance_mm)
    (folder / "places.yaml").write_text(own + (folder / "places.yaml").read_text().split("places:\n")[1])
    result.allowed = len(kept)
    return _tour(own_place, {text: wanted[text] for text in kept})


def _tour(at: tuple[float, float], places: dict[str, tuple[float, float, float]]) -> list[str]:
    """Return the nearest one next."""
    tour, left = [], dict(places)
    while left:
        tour.append(min(left, key=lambda name: math.dist(at, left[name][:2])))
        at = left.pop(tour[-1])[:2]
    return tour


def _drive(folder: Path, settings: dict[str, str], tour: list[str], result: Trial) -> None:
    """Run the tour as `handcart run` does."""
    settings = {**settings, "tour": f"[{', '.join(tour)}]"}
    with prepare(TASK_FILE, settings=settings, seed=result.seed) as prepared:
        scene = prepared.backend.scene  # type: ignore[attr-defined]
        eye = Eye(scene, prepared.robot, prepared.model.places, result)
        execute(prepared, folder / "run", RunOptions(observers=(eye,)))


def _try_nearer(room: Room, folder: Path, settings: dict[str, str], result: Trial) -> None:
    """Places that `check` refuses, as `handcart do` drives to them: none of them may be driven to."""
    places = {"home": _home(folder)}
    for number in range(NEAR):
        share = room.rng.uniform(0.3, 1.0)
        spot = next(room.beside(share * room.least - 0.001))
        places[f"too_near_{number}"] = (*spot, room.rng.uniform(-180.0, 180.0))
    write_places(folder, places)
    world, chart, places_file = (folder / f"{text}.yaml" for text in ("world", "map", "places"))
    files = RigFiles(world, chart, places_file, {})
    with build_rig(files, settings["robot"], seed=result.seed) as rig:
        scene = rig.backend.scene  # type: ignore[attr-defined]
        for name in list(places)[1:]:
            outcome = rig.do(MoveTo(place=name))
            off = 1e3 * scene.base.distance(rig.model.places[name].pose)
            reached = isinstance(outcome, Success)
            result.stood.append(Stood(name, reached, getattr(outcome, "reason", ""), off, 0.0))
        result.contacts += [f"{c.time:.2f} s: {c.body} and {c.other}" for c in scene.contacts]


def _home(folder: Path) -> tuple[float, float, float]:
    from handcart.files.models.loading import load
    from handcart.primitives.knowledge.place import Places

    home = load(folder / "places.yaml", Places).places["home"]
    return home.x_m, home.y_m, home.heading_deg


def report(results: list[Trial], nearer: bool) -> str:
    """Return a report on all worlds."""
    results = sorted(results, key=lambda result: result.seed)
    lines = [f"{len(results)} worlds"]
    for surprised in (False, True):
        chosen = [result for result in results if result.surprised == surprised]
        last = {(trial.seed, s.name): s for trial in chosen for s in trial.stood}
        unreached = [(seed, s) for (seed, _), s in last.items() if not s.reached]
        kind = "with boxes that aren't on the map" if surprised else "without surprises"
        lines.append(
            f"{kind}: {len(chosen)} worlds, {len(last)} places driven to, {len(unreached)} not reached, "
            f"{sum(len(trial.contacts) for trial in chosen)} contacts"
        )
        if not surprised and not nearer:
            lines += [f"  world {seed}, {s.name}: {s.reason}" for seed, s in unreached]
        elif nearer:
            reasons = Counter(s.reason.split(":")[0].rsplit(" ", 1)[0] for _, s in unreached)
            lines += [f"  {count} x {reason}" for reason, count in reasons.most_common(5)]
        lines += [f"  world {trial.seed}: contact at {words}" for trial in chosen for words in trial.contacts]
    reached = [s for result in results for s in result.stood if s.reached]
    if reached:
        off, lost = (np.array([getattr(s, key) for s in reached]) for key in ("off_mm", "lost_mm"))
        lines.append(f"arrival: rms {_rms(off):.1f} mm, most {off.max():.1f} mm")
        lines.append(f"localisation there: rms {_rms(lost):.1f} mm, most {lost.max():.1f} mm")
        lines.append(
            f"nearest that the footprint came to anything: {min(e.nearest_mm for e in results):.1f} mm"
        )
    lines.append(f"places beside things: {sum(e.places for e in results)}, reachable by `check`:")
    lines[-1] += f" {sum(e.allowed for e in results)}"
    wrongly = [f"  world {result.seed}: {words}" for result in results for words in result.wrongly]
    lines.append(f"of which `check` is wrong by distances worked out cell by cell: {len(wrongly)}")
    lines += wrongly
    lines.append(f"{sum(e.seconds for e in results) / max(1, len(results)):.2f} CPU s a world")
    return "\n".join(lines)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--worlds", type=int, default=500)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0, help="of the first world")
    parser.add_argument("--nearer", action="store_true", help="try places that `check` refuses")
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.worlds)
    results = []
    with Progress(console=Console(stderr=True)) as progress, CutOff() as cut:
        bar = progress.add_task("worlds", total=len(seeds))
        for result in each_result(try_world, [(seed, chosen.nearer) for seed in seeds], chosen.jobs):
            results.append(result)
            progress.advance(bar)
    print(report(results, chosen.nearer))
    raise SystemExit(cut.status(not results))


if __name__ == "__main__":
    main()
