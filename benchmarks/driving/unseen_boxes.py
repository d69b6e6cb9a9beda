"""Boxes that no lidar sees: `python -m benchmarks.driving.unseen_boxes [--worlds N] [--backend NAME]`.

Random rooms of 8 to 10 m with two boxes on the map, and two or three that are on no map and in no scan: low
ones under the scan plane, and ones that hang above it, 0.2 to 0.4 m wide, as near to the ways as chance puts
them. `tasks/drive_map` drives through five places, as `handcart run` does it. Contacts are the simulated
world's own: for each box how often it was touched after the first time, and for how long the base was driven
against it. Status 1 unless nothing was touched twice and nothing pushed for more than a second. A base that
rebounds and touches again within a second has touched
once; all that it is driven in between counts as pushing.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np

from benchmarks.cut_off import CutOff
from handcart.backends.robot.robot import Robot
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import prepare
from handcart.robotics.navigation.maps.grid_map import from_boxes

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "drive_map" / "task.yaml"
ROBOT, RADIUS = "librarian", 0.34  # its lidar scans 0.25 m above the floor
PLACE_COUNT = 5
CELL_M = 0.05
WALL_M = 0.1  # [m] thick
FREE_OF_PLACE = 0.3  # [m] between the footprint at a place and a box
SAME_TOUCH_S = 1.0
ALLOWED_PUSHING_S = 1.0
Box = tuple[float, float, float, float, float, float, float]
"""x, y, heading in [rad], length, width, height, underside above the floor; in [m]."""


@dataclass
class Trial:
    """Result of one world."""

    seed: int
    boxes: int = 0
    touched: Counter[str] = field(default_factory=Counter)
    """Number of contacts with each box."""
    pushed: float = 0.0
    """Longest time in [s] for which the base was driven while it touched a box."""
    reached: int = 0
    failed: int = 0
    reasons: list[str] = field(default_factory=list)
    outcome: str = ""
    seconds: float = 0.0


class Eye(RunObserver):
    """Takes the ground truth down."""

    def __init__(self, scene: Any, result: Trial) -> None:
        self._scene, self._result = scene, result
        self._last: dict[str, float] = {}
        self._pushing: dict[str, float] = {}

    def period(self, robot: Robot) -> None:
        touching = {other for _, other in self._scene.touching if other.startswith("unseen")}
        for name in touching:
            if robot.time - self._last.get(name, -math.inf) > SAME_TOUCH_S:
                self._result.touched[name] += 1
                self._pushing[name] = 0.0
            self._last[name] = robot.time
        for name, last in self._last.items():
            if robot.driven[0] != 0.0 and robot.time - last <= SAME_TOUCH_S:
                self._pushing[name] += robot.period
            if name in touching:
                self._result.pushed = max(self._result.pushed, self._pushing[name])

    def event(self, event: Event) -> None:
        if isinstance(event, Ended):
            self._result.reasons.append(f"{event.primitive.label()}: {event.outcome}"[:160])


def try_world(seed: int, backend: str) -> Trial:
    """Make a world and drive through its places."""
    begun, result = time.process_time(), Trial(seed)
    with TemporaryDirectory(prefix="unseen-boxes-") as name:
        folder = Path(name)
        result.boxes = write_world(seed, folder)
        settings = {key: str(folder / f"{key}.yaml") for key in ("map", "world", "places")}
        settings |= {"robot": ROBOT, "wait_s": "1.5"}
        with prepare(TASK_FILE, backend=backend, settings=settings, seed=seed) as prepared:
            eye = Eye(prepared.backend.scene, result)  # type: ignore[attr-defined]
            done = execute(prepared, folder / "run", RunOptions(observers=(eye,)))
        result.outcome = str(done.summary["outcome"])
        result.reasons.append(str(done.summary["reason"])[:900])
    result.seconds = time.process_time() - begun
    return result


def write_world(seed: int, folder: Path) -> int:
    """Write map, world and places of a seed; return how many boxes no lidar sees."""
    rng = np.random.default_rng(seed)
    width, depth = rng.uniform(8.0, 10.0, 2)
    seen = [*_walls(width, depth), *(_box(rng, width, depth, 2.0, 0.0, 1.0) for _ in range(2))]
    places = _places(rng, width, depth, seen)
    unseen: list[Box] = []
    wanted = int(rng.integers(2, 4))
    while len(unseen) < wanted:
        box = _between(rng, places)
        away = min(math.dist(box[:2], place[:2]) for place in places)
        if away > RADIUS + FREE_OF_PLACE + 0.5 * math.hypot(*box[3:5]):
            unseen.append(box)
    _write(folder, (width, depth), seen, unseen, places)
    return len(unseen)


def _walls(width: float, depth: float) -> list[Box]:
    flat = [(width / 2, y, 0.0, width + WALL_M, WALL_M) for y in (0.0, depth)]
    flat += [(x, depth / 2, 0.0, WALL_M, depth) for x in (0.0, width)]
    return [(*item, 2.0, 0.0) for item in flat]


def _box(
    rng: np.random.Generator, width: float, depth: float, height: float, above: float, most: float
) -> Box:
    x, y = rng.uniform([1.5, 1.5], [width - 1.5, depth - 1.5]).tolist()
    length, wide = rng.uniform(0.3, most, 2).tolist()
    return x, y, float(rng.uniform(0.0, math.pi)), length, wide, height, above


def _between(rng: np.random.Generator, places: list[tuple[float, float, float]]) -> Box:
    """Return a low box, or one that hangs, near the straight line between two places that follow each
    other.
    """
    number = int(rng.integers(len(places) - 1))
    (x1, y1, _), (x2, y2, _) = places[number : number + 2]
    share = rng.uniform(0.3, 0.7)
    aside_x, aside_y = rng.normal(0.0, 0.2, 2).tolist()
    x, y = x1 + share * (x2 - x1) + aside_x, y1 + share * (y2 - y1) + aside_y
    length, wide = rng.uniform(0.2, 0.4, 2).tolist()
    height, above = (rng.uniform(0.08, 0.2), 0.0) if rng.random() < 0.5 else (0.6, rng.uniform(0.32, 0.7))
    return x, y, float(rng.uniform(0.0, math.pi)), length, wide, float(height), float(above)


def _places(
    rng: np.random.Generator, width: float, depth: float, seen: list[Box]
) -> list[tuple[float, float, float]]:
    """x, y in [m], heading in [deg]; clear of what is on the map, and 2 m from each other."""
    found: list[tuple[float, float, float]] = []
    while len(found) < PLACE_COUNT + 1:
        x, y = rng.uniform([0.8, 0.8], [width - 0.8, depth - 0.8]).tolist()
        clear = all(math.dist((x, y), box[:2]) > 0.9 + 0.5 * math.hypot(*box[3:5]) for box in seen[4:])
        if clear and all(math.dist((x, y), entry[:2]) > 2.0 for entry in found[-2:]):
            found.append((x, y, float(rng.uniform(-180.0, 180.0))))
    return found


def _write(
    folder: Path,
    size: tuple[float, float],
    seen: list[Box],
    unseen: list[Box],
    places: list[tuple[float, float, float]],
) -> None:
    grid = from_boxes([box[:5] for box in seen], CELL_M, (-0.3, -0.3), (size[0] + 0.6, size[1] + 0.6))
    cv2.imwrite(str(folder / "map.png"), np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {CELL_M}\norigin: [{grid.origin_x}, {grid.origin_y}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    x, y, heading = places[0]
    start = f"format: handcart-world/1\nstart: {{x_m: {x}, y_m: {y}, heading_deg: {heading}}}\n"
    boxes = _listed("furniture", "wall", seen) + _listed("surprises", "unseen", unseen)
    (folder / "world.yaml").write_text(start + boxes)
    names = ["home", *(f"place_{number}" for number in range(1, len(places)))]
    lines = [
        f"  {n}: {{x_m: {x}, y_m: {y}, heading_deg: {h}}}\n"
        for n, (x, y, h) in zip(names, places, strict=True)
    ]
    (folder / "places.yaml").write_text("format: handcart-places/1\nplaces:\n" + "".join(lines))


def _listed(key: str, name: str, boxes: list[Box]) -> str:
    lines = [
        f"  - {{name: {name} {i}, x_m: {x}, y_m: {y}, heading_deg: {math.degrees(yaw)}, "
        f"size_m: [{length}, {width}, {height}], above_m: {above}}}\n"
        for i, (x, y, yaw, length, width, height, above) in enumerate(boxes)
    ]
    return f"{key}:\n" + "".join(lines)


def report(results: list[Trial], backend: str) -> tuple[str, bool]:
    """Return a report on all worlds, and True if all requirements are met."""
    boxes, touched = sum(result.boxes for result in results), Counter[int]()
    for result in results:
        touched.update(result.touched.values())
    again = sum((count - 1) * number for count, number in touched.items())
    pushed = max((result.pushed for result in results), default=0.0)
    ends = Counter(result.outcome for result in results)
    lines = [
        f"{len(results)} worlds with {boxes} low and hanging boxes, backend {backend}: "
        f"{sum(touched.values())} boxes run into; contacts after the first: {again} (allowed: 0); "
        f"longest pushing: {pushed:.2f} s (allowed: {ALLOWED_PUSHING_S:g})",
        f"ends: {', '.join(f'{count} {end}' for end, count in ends.most_common())}; "
        f"{sum(e.seconds for e in results) / max(1, len(results)):.1f} CPU s a world",
    ]
    lines += [
        f"  world {e.seed}: {dict(e.touched)}" for e in results if any(c > 1 for c in e.touched.values())
    ]
    return "\n".join(lines), again == 0 and pushed <= ALLOWED_PUSHING_S


def main() -> None:
    """Try the worlds one after the other."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--worlds", type=int, default=100, help="how many (default: 100)")
    words.add_argument("--seed", type=int, default=0, help="of the first world (default: 0)")
    words.add_argument("--backend", default="kinematic", help="kinematic (the default), mujoco, pybullet")
    words.add_argument("--verbose", action="store_true", help="also print how each action ended")
    chosen = words.parse_args()
    print(f"{chosen.worlds} worlds on {chosen.backend}", flush=True)
    results = []
    with CutOff() as cut:  # report the runs until then
        for seed in range(chosen.seed, chosen.seed + chosen.worlds):
            results.append(try_world(seed, chosen.backend))
            last = results[-1]
            print(
                f"world {seed}: {last.outcome}, touched {dict(last.touched)}, {last.pushed:.2f} s", flush=True
            )
            if chosen.verbose:
                print("\n".join(f"  {reason}" for reason in last.reasons), flush=True)
    text, good = report(results, chosen.backend)
    print(text)
    raise SystemExit(cut.status(not good))


if __name__ == "__main__":
    main()
