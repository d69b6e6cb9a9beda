"""Open doors and drawers of all kinds: `python -m benchmarks.objects.doors_and_drawers`.

Each seed makes a door: one that is pulled or pushed, with its hinge on the left or on the right, 0.6 to 1.1 m
from the handle, by turns, with a friction of 3 to 9 N at the handle. Every fifth seed makes a drawer. The
robot believes in a handle 10 mm off (standard deviation), and in a radius 100 mm off. It opens the door by 20
degrees, the drawer by 200 mm. With `--case` something is wrong besides.

Printed are the Successes, the outcomes that the ground truth contradicts, how far the found hinge is off in
place, direction and radius, and the greatest force on the hand. Status 1 if an outcome was false.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

CASES = ("plain", "locked", "jams", "believed sliding", "believed hinged", "handle off")
HINGE_LIMIT_MM, AXIS_LIMIT_DEG, FORCE_LIMIT_N = 10.0, 1.0, 25.0
DRAWER_EVERY = 5
HANDLE_XY = (3.6, 2.0)
HANDLE_HEIGHT_M = 0.9
DISTANCE_M = {"towards": 0.88, "away": 0.58}
"""Distance of the base from the handle, by the direction in which the door opens."""
ROOM = """format: handcart-world/1
start: {{x_m: {x:.3f}, y_m: 2.0, heading_deg: 0.0}}
walls:
  - {{from_m: [0.0, 0.0], to_m: [6.0, 0.0]}}
  - {{from_m: [6.0, 0.0], to_m: [6.0, 4.0]}}
  - {{from_m: [6.0, 4.0], to_m: [0.0, 4.0]}}
  - {{from_m: [0.0, 4.0], to_m: [0.0, 0.0]}}
doors:
  - {{name: door, {door}, friction_n: {friction:.1f}{wrong}}}
"""
TASK = """format: handcart-task/1
title: Open a door
robot: {robot}
world: world.yaml
knowledge: {{map: map.yaml, places: places.yaml, doors: doors.yaml, start: before}}
start: closed
goal: opened
situations:
  closed: {{door: closed}}
  opened: {{door: open}}
actions:
  - {{do: OPEN, from: closed, to: opened, cost_s: 20, attempts: 1,
     with: {{door: door, angle_deg: 20, travel_mm: 200}}}}
"""


def main() -> None:
    """Run the seeds, and print a row."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seeds", type=int, default=20, help="number of seeds, from --first")
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--backend", default="mujoco")
    words.add_argument("--robot", default="librarian", help="name or file of a robot")
    words.add_argument("--case", choices=CASES, default="plain", help="something that is wrong")
    asked = words.parse_args()
    found: list[dict[str, Any]] = []
    for seed in range(asked.first, asked.first + asked.seeds):
        begun = time.process_time()
        with TemporaryDirectory(prefix="doors-") as folder:
            summary = run_once(Path(folder), asked.backend, asked.robot, seed, asked.case)
        metrics = summary["metrics"]
        print(
            f"{asked.backend} seed {seed} ({describe(seed)}): {summary['outcome']} {summary['reason']};"
            f" hinge off {metrics.get('hinge_off_mm', '-')} mm (sigma {metrics.get('hinge_sigma_mm', '-')}),"
            f" axis {metrics.get('axis_off_deg', '-')} deg, radius {metrics.get('radius_off_mm', '-')} mm,"
            f" force {metrics.get('door_force_n', '-')} N, {time.process_time() - begun:.1f} s CPU",
            file=sys.stderr,
            flush=True,
        )
        found.append(summary)
    sys.exit(print_row(asked.backend, asked.case, found))


def print_row(backend: str, case: str, found: list[dict[str, Any]]) -> int:
    """Print the row; return 1 if an outcome was false, otherwise 0."""
    metrics = [entry["metrics"] for entry in found]
    false = [wrong for metric in metrics for wrong in metric["untrue"]]
    ends = Counter(entry["outcome"] for entry in found)
    within = sum(
        entry["outcome"] == "Success" and _is_within(numbers)
        for entry, numbers in zip(found, metrics, strict=True)
    )
    print(f"{backend}, {case}: {dict(ends)}; false {len(false)}; within all limits {within} of {len(found)}")
    for key, words in (
        ("hinge_off_mm", f"hinge off [mm], limit {HINGE_LIMIT_MM:g}"),
        ("axis_off_deg", f"axis off [deg], limit {AXIS_LIMIT_DEG:g}"),
        ("radius_off_mm", "radius off [mm]"),
        ("door_force_n", f"greatest force [N], limit {FORCE_LIMIT_N:g}"),
    ):
        values = [metric[key] for metric in metrics if key in metric]
        if values:
            middle, high = np.percentile(values, [50.0, 95.0])
            print(f"  {words}: median {middle:.2f}, 95 % {high:.2f}, most {max(values):.2f}")
    for wrong in false:
        print(f"  false: {wrong}")
    return 1 if false else 0


def _is_within(metrics: dict[str, Any]) -> bool:
    limits = {
        "hinge_off_mm": HINGE_LIMIT_MM,
        "axis_off_deg": AXIS_LIMIT_DEG,
        "door_force_n": FORCE_LIMIT_N,
    }
    return all(float(metrics.get(key, 0.0)) <= limit for key, limit in limits.items())


def describe(seed: int) -> str:
    """Return the kind of door of a seed, in words."""
    motion, hinge, opens, radius = _kind(seed)
    return "drawer" if motion == "sliding" else f"{opens}, hinge {hinge}, {radius:.2f} m"


def _kind(seed: int) -> tuple[str, str, str, float]:
    motion = "sliding" if seed % DRAWER_EVERY == DRAWER_EVERY - 1 else "hinged"
    radius = float(np.random.default_rng(seed).uniform(0.6, 1.1))
    opens = "towards" if motion == "sliding" or seed % 2 == 0 else "away"
    return motion, ("left", "right")[seed // 2 % 2], opens, radius


def run_once(folder: Path, backend: str, robot: str, seed: int, case: str = "plain") -> dict[str, Any]:
    """Run the task of a seed below a folder; return its summary."""
    write_task(folder, robot, seed, case)
    summary, _ = run_task(folder / "task.yaml", folder, RunOptions(backend=backend, seed=seed))
    return summary


def write_task(folder: Path, robot: str, seed: int, case: str) -> None:
    """Write the files of a seed: task, world, map, places and doors."""
    from handcart.backends.simulation.world_files.load_world import load_world
    from handcart.backends.simulation.world_files.world_map import map_of_world
    from handcart.files.maps.map_writing import write_grid

    rng = np.random.default_rng((seed, 1))
    motion, hinge, opens, radius = _kind(seed)
    (x, y), far = HANDLE_XY, DISTANCE_M[opens]
    dx, dy = 0.010 * rng.standard_normal(2)
    if case == "handle off":
        dx, dy = 0.0, math.copysign(0.030, dy)
    believed = {"believed sliding": "sliding", "believed hinged": "hinged"}.get(case, motion)
    wrong = {"locked": ", locked: true", "jams": ", jams_deg: 8, jams_mm: 80"}.get(case, "")
    bar = "horizontal" if motion == "sliding" else "vertical"
    tag = "{id: 21, side_mm: 50, up_mm: 90}"
    known = min(1.3, max(0.4, radius + 0.1 * float(rng.standard_normal())))

    def keys(x: float, y: float, motion: str, radius: float) -> str:
        handle = f"{{x_m: {x:.4f}, y_m: {y:.4f}, height_m: {HANDLE_HEIGHT_M}, heading_deg: 180, bar: {bar}}}"
        kind = f"motion: {motion}, hinge: {hinge}, opens: {opens}, radius_m: {radius:.3f}"
        return f"{kind}, height_mm: 400, handle: {handle}, tags: [{tag}]"

    door, friction = keys(x, y, motion, radius), float(rng.uniform(3.0, 9.0))
    world = ROOM.format(x=x - far, door=door, friction=friction, wrong=wrong)
    (folder / "world.yaml").write_text(world, encoding="utf-8")
    write_grid(folder / "map.yaml", map_of_world(load_world(folder / "world.yaml"), 0.25, 0.02))
    places = (
        f"format: handcart-places/1\nplaces:\n  before: {{x_m: {x - far:.3f}, y_m: {y}, heading_deg: 0.0}}\n"
    )
    (folder / "places.yaml").write_text(places, encoding="utf-8")
    belief = keys(x + dx, y + dy, believed, known)
    doors = f"format: handcart-doors/1\ndoors:\n  door: {{{belief}, place: before}}\n"
    (folder / "doors.yaml").write_text(doors, encoding="utf-8")
    (folder / "task.yaml").write_text(TASK.format(robot=robot), encoding="utf-8")


if __name__ == "__main__":
    main()
