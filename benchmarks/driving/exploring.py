"""EXPLORE in buildings of several rooms with loops: python -m benchmarks.driving.exploring [--worlds N]

Each world is a building of its own with doors of 0.95 to 1.4 m, loops and furniture; the robot is given no
map. Measured by the ground truth: share of the floor it could stand on that the map shows, distance of each
occupied cell to the nearest true surface in the frame of the start (nothing is aligned), contacts, and false
outcomes. Status 1 unless all end in Success without contact or false outcome, and the wall errors of all
worlds together are within 3 cm (median) and 8 cm (95 %).
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from handcart.evaluation.judging.map_survey import compare_with_world
from handcart.evaluation.judging.survey import SurveyedRun, simulated_world
from handcart.evaluation.judging.surveys import Surveys
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.exploring.explore import Explore
from handcart.robotics.numerics.arrays import FloatArray

from .worlds.building import make_building, write_building

SIZES = ((2, 2), (2, 3), (3, 3))
MAX_MEDIAN_MM, MAX_95_MM = 30.0, 80.0


class Result(NamedTuple):
    """One exploration."""

    outcome: str
    reason: str
    walls_mm: FloatArray
    mapped_percent: float
    missing_percent: float
    contacts: int
    false: list[str]
    driven_m: float
    seconds: float
    loops: int
    cpu_s: float


def explore(seed: int, size: tuple[int, int], robot: str, backend: str, pictures: Path | None) -> Result:
    """Explore the building of a seed."""
    with TemporaryDirectory(prefix="exploring-") as name:
        world = write_building(make_building(seed, *size), Path(name))
        with build_rig(RigFiles.without_map(world), robot, backend, seed) as rig:
            return _explored(rig, seed, pictures)


def _explored(rig: Rig, seed: int, pictures: Path | None) -> Result:
    made, begun = Explore(), time.process_time()
    scene = simulated_world(rig.backend)
    assert scene is not None
    run = SurveyedRun(rig.robot, rig.robot.spec, rig.model, scene, seed, frozenset({"EXPLORE"}))
    surveys = Surveys(run)
    surveys.started(1, made)
    outcome = rig.do(made)
    spent = time.process_time() - begun
    false = surveys.ended(1, made, outcome)
    drawn = made.evidence.maps.get("explored")
    if pictures is not None and drawn is not None:
        import cv2

        cv2.imwrite(str(pictures / f"building_{seed}.png"), made.evidence.pictures["map"])
    found = None if drawn is None else compare_with_world(run, drawn, made.radius_m)
    return Result(
        type(outcome).__name__,
        str(getattr(outcome, "reason", "")),
        np.empty(0) if found is None else found.walls_mm,
        0.0 if found is None else found.mapped_percent,
        100.0 if found is None else found.missing_percent,
        len(scene.contacts),
        list(false),
        float(made.facts.get("driven_m", 0.0)),
        rig.robot.time,
        int(made.facts.get("loop_closures", 0)),
        spent,
    )


def _line(seed: int, size: tuple[int, int], found: Result) -> str:
    walls = found.walls_mm if len(found.walls_mm) else np.array([np.nan])
    words = (
        f"{seed:4d} {size[0]} x {size[1]} rooms: {found.outcome:8} {found.driven_m:6.1f} m "
        f"{found.seconds:6.0f} s {found.loops:4d} loops, "
        f"walls {np.median(walls):5.1f} / {np.quantile(walls, 0.95):5.1f} mm, "
        f"mapped {found.mapped_percent:6.2f} %, lacks {found.missing_percent:.2f} % of the walls, "
        f"contacts {found.contacts}, CPU {found.cpu_s:.0f} s"
    )
    return (
        words
        + (f"; {found.reason}" if found.reason else "")
        + "".join(f"\n  FALSE: {w}" for w in found.false)
    )


def main() -> None:
    """Explore the buildings one after the other."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.driving.exploring", description=__doc__)
    words.add_argument("--worlds", type=int, default=12, help="number of buildings (default: 12)")
    words.add_argument("--first", type=int, default=0, metavar="SEED", help="seed of the first (default: 0)")
    words.add_argument("--robot", default="cart", help="robot (default: cart)")
    words.add_argument("--backend", default="kinematic", help="backend (default: kinematic)")
    words.add_argument("--pictures", type=Path, help="existing folder for a picture of each map")
    asked = words.parse_args()
    print(f"{asked.worlds} buildings, {asked.robot} on {asked.backend}", flush=True)
    results = list[Result]()
    for seed in range(asked.first, asked.first + asked.worlds):
        size = SIZES[seed % len(SIZES)]
        results.append(explore(seed, size, asked.robot, asked.backend, asked.pictures))
        print(_line(seed, size, results[-1]), flush=True)
    walls = np.concatenate([result.walls_mm for result in results])
    median, high = float(np.median(walls)), float(np.quantile(walls, 0.95))
    reached = sum(result.outcome == "Success" for result in results)
    contacts, false = sum(result.contacts for result in results), sum(len(result.false) for result in results)
    mapped = min(result.mapped_percent for result in results)
    print(
        f"all: {reached} of {len(results)} Success; walls {median / 10:.1f} / {high / 10:.1f} cm "
        f"(must: 3 / 8); floor mapped at least {mapped:.1f} %; contacts {contacts}; false outcomes {false}"
    )
    is_good = reached == len(results) and median <= MAX_MEDIAN_MM and high <= MAX_95_MM
    raise SystemExit(0 if is_good and not contacts and not false else 1)


if __name__ == "__main__":
    main()
