"""Plan and build random walls from their drawings, and measure the errors of the blocks.

python -m benchmarks.blocks.walls [WALLS [ROBOT]]

Each wall is drawn by its seed: 15 blocks in two or three rows, on a table at a random pose, with a
landmark at a random position beside the wall. It is planned by `handcart wall` and built once; "raw max"
is the largest distance of a block from its drawn position, by the ground truth, over all walls.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from pathlib import Path

import numpy as np

from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.blocks.wall_files import write_wall
from handcart.evaluation.blocks.wall_planning import WallPlan, plan_wall
from handcart.evaluation.trials.running import run_task
from handcart.evaluation.viewing.drawing.picture_file import write_png
from handcart.files.models.loading import load_document
from handcart.files.yaml.yaml_document import read_document
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.blocks.drawing import Drawing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.numerics.arrays import FloatArray

WALL_COUNT = 20
RESOLUTION, ORIGIN, SIZE = 0.02, (-0.2, -0.2), (6.4, 4.4)
WIDE, DEEP, HIGH = 0.9, 0.6, 0.4  # [m] of the wall's table
BLOCK_PITCH_MM = 90.0  # [mm] from block to block
ROW_LENGTHS = {2: (8, 7), 3: (6, 5, 4)}
"""Number of blocks in each row, the lowest first: each block rests on two of the row below."""
BLOCK_COUNT = 15


def draw_wall(seed: int, folder: Path) -> None:
    """Write drawing.yaml, map.yaml and map.png: a wall of 15 blocks in two or three rows."""
    rng = np.random.default_rng(seed)
    rows = ROW_LENGTHS[int(rng.integers(2, 4))]
    table = Pose2(
        4.2 + float(rng.uniform(-0.2, 0.2)),
        2.0 + float(rng.uniform(-0.2, 0.2)),
        float(rng.uniform(-0.5, 0.5)),
    )
    back = float(rng.uniform(-0.14, -0.06))
    mark = table.compose(Pose2(float(rng.uniform(-0.3, 0.3)), back - 0.10, 0.0))
    lines = [
        f"# A wall of 15 blocks, drawn with seed {seed}.",
        "format: handcart-drawing/1",
        "start: {x_m: 2.8, y_m: 0.8}",
        "block_mm: [25, 80, 40]",
        "landmarks:",
        "  supply: {x_m: 1.5, y_m: 1.72, height_m: 0.4}",
        f"  wall: {{{_pose(mark)}, height_m: {HIGH}}}",
        "tables:",
        "  supply table: {x_m: 1.5, y_m: 1.95, height_m: 0.4, size_m: [0.76, 0.66]}",
        f"  stacking table: {{{_pose(table)}, height_m: {HIGH}, size_m: [{WIDE}, {DEEP}]}}",
        "supply:",
        *(
            f"  - {{x_m: {1.32 + 0.09 * (n % 5):.3f}, y_m: {1.98 - 0.08 * (n // 5):.3f}, "
            "height_m: 0.4, heading_deg: 90}"
            for n in range(BLOCK_COUNT)
        ),
        "carried:",
        *(f"  - {{x_m: {x:.2f}, y_m: 0.0, height_m: 0.45}}" for x in np.linspace(-0.36, -0.16, 5)),
        "rows:",
    ]
    for level, blocks in enumerate(rows):
        first = table.compose(Pose2(-BLOCK_PITCH_MM / 1e3 * (blocks - 1) / 2, back, -math.pi / 2))
        along = ", ".join(f"{BLOCK_PITCH_MM * n:g}" for n in range(blocks))
        lines.append(f"  - {{{_pose(first)}, height_m: {HIGH + 0.04 * level:.2f}, along_mm: [{along}]}}")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "drawing.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    _draw_map(table, folder)


def _draw_map(table: Pose2, folder: Path) -> GridMap:
    feet = [(1.5, 1.95, 0.0, 0.304, 0.264), (*table, 0.4 * WIDE, 0.4 * DEEP)]
    walls = [(3.0, -0.05, 0.0, 6.1, 0.1), (3.0, 4.05, 0.0, 6.1, 0.1)]
    walls += [(-0.05, 2.0, 0.0, 0.1, 4.2), (6.05, 2.0, 0.0, 0.1, 4.2)]
    grid = from_boxes([*feet, *walls], RESOLUTION, ORIGIN, SIZE)
    write_png(folder / "map.png", np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {RESOLUTION}\norigin: [{ORIGIN[0]}, {ORIGIN[1]}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )
    return grid


def plan_drawn(folder: Path, robot: str) -> WallPlan:
    """Return the plan of the wall in a folder, written there as a task; raises FileError where it can't be
    built.
    """
    from handcart.primitives.knowledge.place import load_map

    loaded = load_document(read_document(folder / "drawing.yaml"), Drawing)
    plan = plan_wall(loaded, load_robot(robot), load_map(folder / "map.yaml")[0])
    write_wall(plan, folder / "map.yaml", robot, folder)
    return plan


def main() -> None:
    """Print a line for each wall, and the row."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("walls", nargs="?", type=int, default=WALL_COUNT)
    words.add_argument("robot", nargs="?", default="toyama/h1")
    wanted = words.parse_args()
    count, robot = wanted.walls, wanted.robot
    print(f"{'wall':>4}{'rows':>5}{'stops':>6}{'plan s':>7}{'blocks':>7}{'mean mm':>8}{'max mm':>7}  ended")
    built, errors, touched = 0, list[FloatArray](), 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(count):
            place, began = Path(folder) / str(seed), time.perf_counter()
            draw_wall(seed, place)
            plan = plan_drawn(place, robot)
            took = time.perf_counter() - began
            summary, _ = run_task(place / "task.yaml", place / "run", RunOptions(seed=seed))
            metrics = summary["metrics"]
            off = np.array([math.hypot(item["x"], item["y"]) for item in metrics.get("blocks", [])])
            stops = len(plan.fetching) + len(plan.laying)
            unmeant = int(metrics.get("contacts_unmeant", 0))
            rows = len(plan.drawing.rows)
            print(
                f"{seed:4}{rows:5}{stops:6}{took:7.0f}{len(off):7}{off.mean() if len(off) else 0:8.2f}"
                f"{off.max() if len(off) else 0:7.2f}  {summary['outcome']}, {unmeant} unmeant contacts"
                f" {summary['reason'][:80]}",
                flush=True,
            )
            built += summary["outcome"] == "Success" and len(off) == BLOCK_COUNT
            errors.append(off)
            touched += unmeant
    every = np.concatenate(errors)
    raw = f"raw mean {every.mean():.2f} mm, max {every.max():.2f} mm"
    print(f"{built} of {count} built, {raw}, {touched} collisions")


def _pose(pose: Pose2) -> str:
    return f"x_m: {pose.x:.4f}, y_m: {pose.y:.4f}, heading_deg: {math.degrees(pose.theta):.3f}"


if __name__ == "__main__":
    main()
