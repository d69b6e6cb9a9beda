"""Walls on the borders of a map's cells, seen from one side: python -m benchmarks.driving.cell_borders

Each run has two walls at a right angle and nothing else: no wall opposite takes away what the map's cells
leave unsure. In half of the runs their surfaces lie exactly on borders of cells, in the others anywhere in a
cell; they are 0.01 to 0.2 m thick. The map shows every cell that a wall overlaps, or (every third run) what a
lidar drew of the walls from 40 places. A robot drives to four places, 2 to 6 m from the walls. The ground
truth judges: a Success is false if the base is farther off its place than the tolerance (80 mm, in every
fourth run 40 mm) or 1 degree, a Fail if it is over 45 mm or 2 degrees from its start. The pose's error is
compared with the claimed sigma as well.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.driving.cluttered_robot import write_robot
from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.ray_counts import count_rays
from handcart.robotics.navigation.mapping.scan_log import Keyframe
from handcart.robotics.navigation.mapping.scan_surface import Surface
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.numerics.arrays import FloatArray

CELL_M, LENGTH_M, WALL_HEIGHT_M = 0.05, 24.0, 0.8
THICKNESSES_M = (0.01, 0.05, 0.1, 0.15, 0.2)
MAX_TURN_DEG, FAIL_LIMIT = 1.0, (45.0, 2.0)  # of a Success, and of a Fail in [mm], [deg]
REACH_M, RANGE_SIGMA_M, MAPPED_FROM = 12.0, 0.01, 40
FIRST_PLACE, PLACES = (4.0, 4.0), 4

Box = tuple[float, float, float, float, float]


class Case(NamedTuple):
    """One run."""

    seed: int
    offsets: tuple[float, float]
    """Distances of both surfaces from a border, in cells."""
    thickness_m: float
    is_drawn: bool
    """True if a lidar drew the map."""
    tolerance_mm: float


class Arrival(NamedTuple):
    """Result of one MOVE_TO."""

    outcome: str
    reason: str
    off_mm: float
    off_deg: float
    pose_off_mm: float
    """Error of the estimated pose."""
    pose_sigmas: float
    """Pose error in sigmas of the claimed covariance."""
    false: bool


def draw_case(seed: int) -> Case:
    """Return the case of a seed."""
    rng = np.random.default_rng([seed, 91])
    exact = seed % 2 == 0
    offsets = (0.0, 0.0) if exact else tuple(rng.uniform(-0.5, 0.5, 2).tolist())
    thickness, tolerance = float(rng.choice(THICKNESSES_M)), 40.0 if seed % 4 == 0 else 80.0
    return Case(seed, offsets, thickness, seed % 3 == 2, tolerance)


def walls(case: Case) -> list[Box]:
    """Return the walls x < 0 and y < 0, as thick as the case says, moved by its offsets."""
    x, y = (CELL_M * offset - case.thickness_m / 2 for offset in case.offsets)
    half = LENGTH_M / 2
    return [(x, half, 0.0, case.thickness_m, LENGTH_M), (half, y, 0.0, LENGTH_M, case.thickness_m)]


def map_of(case: Case) -> GridMap:
    """Return the map of a case."""
    boxes = walls(case)
    if not case.is_drawn:
        return from_boxes(boxes, CELL_M, (-1.0, -1.0), (LENGTH_M + 1.0, LENGTH_M + 1.0))
    rng = np.random.default_rng([case.seed, 92])
    poses = [Pose2(x, y, 0.0) for x, y in rng.uniform(1.0, 9.0, (MAPPED_FROM, 2)).tolist()]
    drawn = count_rays([_seen(boxes, pose, rng) for pose in poses], poses, CELL_M).grid
    return drawn._replace(unknown=np.zeros_like(drawn.unknown))


def _seen(boxes: list[Box], pose: Pose2, rng: np.random.Generator) -> Keyframe:
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    ranges = box_ranges(boxes, pose, angles) + rng.normal(0.0, RANGE_SIGMA_M, len(angles))
    hit = ranges < REACH_M
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    none: FloatArray = np.empty((0, 2))
    surface = Surface(none, none)
    return Keyframe(0, pose, surface, ranges[hit, None] * rays[hit], none, np.zeros(2))


def write_files(case: Case, folder: Path) -> RigFiles:
    """Write map, places, world and robot of a case."""
    grid = map_of(case)
    Image.fromarray(np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1]).save(folder / "map.png")
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {CELL_M}\norigin: [{grid.origin_x}, {grid.origin_y}, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    rng = np.random.default_rng([case.seed, 93])
    where = [FIRST_PLACE, *rng.uniform(2.0, 6.0, (PLACES, 2)).tolist()]
    places = {
        f"place {i}": {
            "x_m": round(x, 3),
            "y_m": round(y, 3),
            "heading_deg": 0.0,
            "tolerance_mm": case.tolerance_mm,
        }
        for i, (x, y) in enumerate(where)
    }
    (folder / "places.yaml").write_text(json.dumps({"format": "handcart-places/1", "places": places}))
    start = {"x_m": FIRST_PLACE[0], "y_m": FIRST_PLACE[1], "heading_deg": 0.0}
    things = [
        {"name": f"wall {i}", "x_m": x, "y_m": y, "size_m": [length, width, WALL_HEIGHT_M]}
        for i, (x, y, _, length, width) in enumerate(walls(case))
    ]
    world = {"format": "handcart-world/1", "start": start, "furniture": things}
    (folder / "world.yaml").write_text(json.dumps(world))
    write_robot(folder, (0.22,), 1.0, "scan")
    return RigFiles(folder / "world.yaml", folder / "map.yaml", folder / "places.yaml", {}, "place 0")


def drive(case: Case, places: int = PLACES) -> list[Arrival]:
    """Drive to so many places of a case; each outcome with what the ground truth says of it."""
    with tempfile.TemporaryDirectory() as name:
        files = write_files(case, Path(name))
        with build_rig(files, robot=str(Path(name) / "robot.yaml"), seed=case.seed) as rig:
            return [_arrival(rig, f"place {i}", case.tolerance_mm) for i in range(1, places + 1)]


def _arrival(rig: Rig, place: str, tolerance_mm: float) -> Arrival:
    before = _truth(rig)
    outcome = rig.do(MoveTo(place=place, wait_s=0.0))
    after, success = _truth(rig), isinstance(outcome, Success)
    wanted = rig.model.places[place].pose if success else before
    off, turned = 1e3 * after.distance(wanted), math.degrees(after.turn(wanted))
    far, askew = (tolerance_mm, MAX_TURN_DEG) if success else FAIL_LIMIT
    false = not isinstance(outcome, GiveUp) and (off > far or turned > askew)
    error = np.array([rig.robot.pose.x - after.x, rig.robot.pose.y - after.y])
    sigmas = math.sqrt(float(error @ np.linalg.solve(rig.robot.localization.covariance[:2, :2], error)))
    reason = getattr(outcome, "reason", "")
    return Arrival(type(outcome).__name__, reason, off, turned, 1e3 * float(np.hypot(*error)), sigmas, false)


def _truth(rig: Rig) -> Pose2:
    truth = rig.backend.ground_truth()
    assert truth is not None, "the backend is simulated"
    return truth.base


def main() -> None:
    """Drive the runs one after the other."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--runs", type=int, default=60)
    words.add_argument("--first", type=int, default=0, help="the first seed")
    words.add_argument("--verbose", action="store_true", help="a line for each MOVE_TO")
    chosen = words.parse_args()
    every: list[Arrival] = []
    for seed in range(chosen.first, chosen.first + chosen.runs):
        case = draw_case(seed)
        print(f"\rrun {seed} ...", end="", file=sys.stderr, flush=True)
        for arrival in drive(case):
            every.append(arrival)
            if arrival.false or chosen.verbose:
                print(f"\r{json.dumps(case._asdict())}\n  {arrival}", flush=True)
    false, off = (
        sum(arrival_.false for arrival_ in every),
        np.array([arrival_.pose_off_mm for arrival_ in every]),
    )
    sigmas = np.array([arrival_.pose_sigmas for arrival_ in every])
    ends = ", ".join(f"{count} {end}" for end, count in Counter(e.outcome for e in every).most_common())
    print(f"\r{chosen.runs} runs, {ends}: {false} false Success or Fail")
    print(
        f"pose error: median {np.median(off):.0f} mm, most {off.max():.0f} mm; "
        f"most {sigmas.max():.1f} sigma, beyond 3 sigma {int((sigmas > 3.0).sum())} of {len(every)}"
    )
    arrived = np.array([arrival_.off_mm for arrival_ in every if arrival_.outcome == "Success"])
    if len(arrived):
        print(f"off its place: median {np.median(arrived):.0f} mm, most {arrived.max():.0f} mm")
    raise SystemExit(1 if false else 0)


if __name__ == "__main__":
    main()
