"""Offer wrong objects, clutter and occupied spots: `python -m benchmarks.objects.wrong_objects`.

The task is that of `benchmarks.objects.fetch_and_carry`, with one of these by turns:

- swapped tags: a tin has the tag of the parcel that is wanted;
- a twin: another parcel with the same tag is on the table, near it or far from it;
- clutter: something that no file has stands 12 to 40 mm beside the parcel;
- an occupied spot: something that no file has stands at the spot, or reaches onto it.

A run may end with any outcome. Counted are those that the ground truth contradicts: another object in the
hand at a Success of PICK, anything pushed or thrown over, an object put down where something stands. Status 1
if there is any.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

from .fetch_and_carry import TASK_FOLDER, measure, print_rows
from .without_tags import write_robot

ROBOT_NAMES = ("librarian", "librarian with depth")
PARCEL_XY, SPOT_XY = (1.9, 3.65), (5.05, 2.2)
PARCEL_RADIUS_M = 0.054
TAG_OF_PARCEL = "    tags: [{id: 7, side_mm: 40}]\n"


def main() -> None:
    """Print a row for each robot and backend."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seeds", type=int, default=20, help="number of seeds, from --first")
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--backends", nargs="+", default=["kinematic"])
    words.add_argument("--robots", nargs="+", choices=ROBOT_NAMES, default=list(ROBOT_NAMES))
    asked = words.parse_args()
    seeds = range(asked.first, asked.first + asked.seeds)
    rows = {
        (robot, name): measure(name, robot, seeds, run_once)
        for robot in asked.robots
        for name in asked.backends
    }
    sys.exit(print_rows(rows))


def run_once(folder: Path, backend: str, robot: str, seed: int) -> dict[str, Any]:
    """Run the task once below a folder; return its summary."""
    has_depth = robot == ROBOT_NAMES[1]
    settings = {
        "robot": str(write_robot(folder)) if has_depth else robot,
        "world": str(write_scene(folder, seed)),
        "spot": "left",
    }
    options = RunOptions(backend=backend, settings=settings, seed=seed)
    summary, _ = run_task(TASK_FOLDER / "task.yaml", folder, options)
    return summary


def write_scene(folder: Path, seed: int) -> Path:
    """Write the world with what a seed adds to it."""
    text, rng = (TASK_FOLDER / "world.yaml").read_text(encoding="utf-8"), np.random.default_rng(seed)
    case, exact = seed % 4, ("    sigma_mm: 40\n    sigma_deg: 30\n", "    sigma_mm: 5\n    sigma_deg: 30\n")
    if case == 0:
        text = text.replace(TAG_OF_PARCEL, "    tags: [{id: 9, side_mm: 40}]\n")
        tag = "shape: cylinder, size_mm: [64, 64, 76], tags: [{id: 7, side_mm: 40}]"
        text += _thing("tin", rng.uniform(1.7, 2.1), 3.78, rng, tag)
    elif case == 1:
        tag = "size_mm: [60, 90, 80], tags: [{id: 7, side_mm: 40}]"
        text += _thing("twin", PARCEL_XY[0] + rng.choice([-0.2, 0.13]), PARCEL_XY[1], rng, tag)
    elif case == 2:
        text = text.replace(*exact)
        x, y = _beside(PARCEL_XY, PARCEL_RADIUS_M + rng.uniform(0.012, 0.04), rng)
        text += _thing("clutter", x, y, rng, f"size_mm: [50, 50, {rng.uniform(60, 160):.0f}]")
    else:
        x, y = _beside(SPOT_XY, rng.uniform(0.0, 0.06) - 0.025, rng)
        text += _thing("squatter", x, y, rng, f"size_mm: [50, 50, {rng.uniform(15, 140):.0f}]")
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def _beside(place: tuple[float, float], away: float, rng: np.random.Generator) -> tuple[float, float]:
    """Return a point from which a thing 50 mm wide is `away` in [m] from a place, in any direction."""
    turn = rng.uniform(0.0, 2.0 * math.pi)
    return place[0] + (away + 0.025) * math.cos(turn), place[1] + (away + 0.025) * math.sin(turn)


def _thing(name: str, x: float, y: float, rng: np.random.Generator, keys: str) -> str:
    """Return a thing of the world, on either table."""
    turn = rng.uniform(0.0, 90.0)
    at = f"x_m: {x:.3f}, y_m: {y:.3f}, height_m: 0.6, heading_deg: {turn:.0f}"
    return f"  - {{name: {name}, {at}, mass_kg: 0.3, {keys}}}\n"


if __name__ == "__main__":
    main()
