"""Fetch an object without tags, found by its size in depths: `python -m benchmarks.objects.without_tags`.

The task is that of `benchmarks.objects.fetch_and_carry`. The robot has a depth camera beside the grey one,
with the errors of structured light. Two boxes and two cylinders are known; with each seed another one is
fetched, and another kind is beside it. All are off their believed places by a standard deviation of 40 mm
and 30 degrees. With `--times N` the camera's noise and scale err N times as much, which the robot does not
know. Status 1 if an outcome was false.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.sensors.depth_spec import DepthErrors
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

from .fetch_and_carry import SPOT_NAMES, TASK_FOLDER, measure, print_rows, write_world

ROBOT_NAME = "librarian"
LOOK_DEG = "6"  # at which the widest box still fits between the fingers: 60 cos + 90 sin of it is 69 of 70 mm
DEPTH_CAMERA_YAML = """\
sensors:
  depth:
    {kind: depth_camera, frame: camera, width_px: 320, height_px: 240, focal_px: 280,
     errors: {sigma_mm: %g, sigma_mm_per_m2: %g, scale_percent: %g}}
"""


class Shape(NamedTuple):
    """Shape and size of a kind of objects."""

    shape: str
    size_mm: str


OBJECT_SHAPES = {
    "parcel": Shape("box", "[60, 90, 80]"),
    "can": Shape("cylinder", "[62, 62, 115]"),
    "carton": Shape("box", "[50, 120, 60]"),
    "tin": Shape("cylinder", "[58, 58, 72]"),
}


def main() -> None:
    """Print a row for each backend."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seeds", type=int, default=20, help="number of seeds, from --first")
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--backends", nargs="+", default=["kinematic", "mujoco"])
    words.add_argument("--times", type=float, default=1.0, help="times the depth camera's usual errors")
    asked = words.parse_args()
    seeds, run = range(asked.first, asked.first + asked.seeds), partial(run_once, times=asked.times)
    rows = {(ROBOT_NAME, name): measure(name, ROBOT_NAME, seeds, run) for name in asked.backends}
    sys.exit(print_rows(rows))


def run_once(folder: Path, backend: str, robot: str, seed: int, times: float = 1.0) -> dict[str, Any]:
    """Run the task once below a folder, with so many times the usual errors; return its summary."""
    names = list(OBJECT_SHAPES)
    wanted, other = names[seed % 4], names[(seed + 1 + seed // 4 % 3) % 4]
    settings = {
        "robot": str(write_robot(folder, robot, times)),
        "world": str(write_scene(folder, seed, wanted, other)),
        "objects": str(write_objects(folder, wanted, other)),
        "object": "wanted",
        "look_deg": LOOK_DEG,
        "spot": SPOT_NAMES[seed // 4 % len(SPOT_NAMES)] or "null",
    }
    options = RunOptions(backend=backend, settings=settings, seed=seed)
    summary, _ = run_task(TASK_FOLDER / "task.yaml", folder, options)
    return summary


def write_robot(folder: Path, robot: str = ROBOT_NAME, times: float = 1.0) -> Path:
    """Copy a shipped robot, with a depth camera at its frame `camera` that errs so many times as usual."""
    usual = DepthErrors()
    sigmas = usual.sigma_mm, usual.sigma_mm_per_m2, usual.scale_percent
    copy = folder / robot
    shutil.copytree(SHIPPED_FOLDER / robot, copy)
    with (copy / "robot.yaml").open("a", encoding="utf-8") as file:
        file.write(DEPTH_CAMERA_YAML % tuple(times * sigma for sigma in sigmas))
    return copy / "robot.yaml"


def write_scene(folder: Path, seed: int, wanted: str, other: str) -> Path:
    """Write the world with two objects, and with odd seeds a crate on the way."""
    text = write_world(folder, seed).read_text(encoding="utf-8")
    begin, end = text.index("objects:"), text.find("surprises:")
    rest = text[end:] if end > 0 else ""
    things = (
        f"objects:\n  - {{name: wanted, {_in_world(wanted)}, x_m: 1.9, y_m: 3.65, heading_deg: 20}}\n"
        f"  - {{name: other, {_in_world(other)}, x_m: 2.3, y_m: 3.7, heading_deg: 70}}\n"
    )
    path = folder / "scene.yaml"
    path.write_text(text[:begin] + things + rest, encoding="utf-8")
    return path


def write_objects(folder: Path, wanted: str, other: str) -> Path:
    """Write what the robot knows: all kinds, none with a tag."""
    text = (TASK_FOLDER / "objects.yaml").read_text(encoding="utf-8")
    surfaces = text[text.index("surfaces:") : text.index("objects:\n")]
    kinds = "".join(
        f"  {name}: {{shape: {shape.shape}, size_mm: {shape.size_mm}, mass_kg: 0.3}}\n"
        for name, shape in OBJECT_SHAPES.items()
    )
    objects = (
        f"objects:\n  wanted: {{kind: {wanted}, on: table_a, x_m: 1.9, y_m: 3.65, heading_deg: 20}}\n"
        f"  other: {{kind: {other}, on: table_a, x_m: 2.3, y_m: 3.7, heading_deg: 70}}\n"
    )
    path = folder / "objects.yaml"
    path.write_text(f"format: handcart-objects/1\nkinds:\n{kinds}{surfaces}{objects}", encoding="utf-8")
    return path


def _in_world(kind: str) -> str:
    shape, size = OBJECT_SHAPES[kind]
    return f"shape: {shape}, size_mm: {size}, height_m: 0.6, sigma_mm: 40, sigma_deg: 30"


if __name__ == "__main__":
    main()
