"""Drive corridors with and without pillars with wheel errors: python -m benchmarks.driving.corridor

Each run has a corridor of 20 to 100 m, closed at both ends, wheels whose radius and slip have errors with
a sigma of 0.2 to 5 %, a lidar of 4 to 12 m range, and in half of the runs a pallet across the corridor.
The robot's file does not state these errors. The ground truth judges, within limits that no claim changes:
a Success of MOVE_TO is false if the base is farther off than the place's tolerance (40 mm; in a quarter of
the runs 500 mm, with odd seeds along the corridor alone; 1 degree), a Fail if it is over 45 mm or 2
degrees from its start. With pillars, a run without a pallet should reach both places. In a hall
most of the way is farther from every wall than the lidar sees.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.cut_off import CutOff
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2

CELL_M, HOME_M = 0.05, 3.3
CORRIDOR_M, HALL_M = 3.2, 30.0  # wide
CRATE_M, CRATES = 0.6, ((-1.6, 1.5), (0.4, -1.9), (1.9, 1.2), (-0.6, 2.2))  # middles from a place
PILLAR_EVERY_M, PILLAR_M = 3.0, 0.3
SUCCESS_LIMIT, FAIL_LIMIT = (40.0, 1.0), (45.0, 2.0)  # [mm], [deg]
SHIFTED_M, TURNED_DEG = (0.4, 1.5), (20.0, 180.0)  # of a wrong start


class Case(NamedTuple):
    """One run."""

    seed: int
    length_m: float
    wheels_percent: float
    reach_m: float
    tolerance_mm: float
    pallet: bool
    pillars: bool
    backend: str
    wrong_start: bool
    width_m: float = CORRIDOR_M


class Ended(NamedTuple):
    """Result of one MOVE_TO."""

    outcome: str
    reason: str
    off_mm: float
    off_deg: float
    false: bool


def draw(seed: int, pillars: bool, backend: str, wrong_start: bool, width: float = CORRIDOR_M) -> Case:
    """Return the case of a seed."""
    rng = np.random.default_rng([seed, 77])
    return Case(
        seed,
        float(rng.uniform(20.0, 100.0)),
        float(np.exp(rng.uniform(math.log(0.2), math.log(5.0)))),
        float(rng.uniform(4.0, 12.0)),
        500.0 if rng.uniform() < 0.25 else 40.0,
        bool(rng.uniform() < 0.5),
        pillars,
        backend,
        wrong_start,
        width,
    )


def make_files(case: Case, folder: Path) -> RigFiles:
    """Map, places, world and robot in a folder."""
    columns, rows = round(case.length_m / CELL_M), round(case.width_m / CELL_M)
    cells = np.full((rows, columns), 254, np.uint8)
    cells[:2] = cells[-2:] = 0
    cells[:, :2] = cells[:, -2:] = 0
    if case.pillars:
        every, size = round(PILLAR_EVERY_M / CELL_M), round(PILLAR_M / CELL_M)
        for at in range(100, columns - 50, every):
            cells[2 : 2 + size, at : at + size] = cells[-2 - size : -2, at : at + size] = 0
    along = {"home": HOME_M, "middle": 0.5 * case.length_m, "far": 0.7 * case.length_m}
    if case.width_m > CORRIDOR_M:
        for name in ("home", "far")[: 1 + case.seed % 2]:
            _draw_crates(cells, along[name], 0.5 * case.width_m)
    Image.fromarray(cells).save(folder / "map.png")
    (folder / "map.yaml").write_text(
        "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    place: dict[str, Any] = {"y_m": case.width_m / 2, "heading_deg": 0.0, "tolerance_mm": case.tolerance_mm}
    if is_by_direction(case):
        place["tolerance_mm"] = {"along": case.tolerance_mm, "across": SUCCESS_LIMIT[0]}
    places = {name: {"x_m": round(x, 3), **place} for name, x in along.items()}
    (folder / "places.yaml").write_text(json.dumps({"format": "handcart-places/1", "places": places}))
    off = moved_start(case)
    world: dict[str, Any] = {
        "format": "handcart-world/1",
        "map": "map.yaml",
        "start": {
            "x_m": round(HOME_M + off.x, 4),
            "y_m": round(case.width_m / 2 + off.y, 4),
            "heading_deg": round(math.degrees(off.theta), 3),
        },
    }
    if case.pallet:
        x = round(0.6 * case.length_m, 3)
        world["surprises"] = [
            {"name": "pallet", "x_m": x, "y_m": case.width_m / 2, "size_m": [0.6, 3.0, 0.5]}
        ]
    (folder / "world.yaml").write_text(yaml.safe_dump(world))
    (folder / "robot").mkdir()
    source = load_robot("cart").folder
    for path in source.iterdir():
        if path.is_file():
            (folder / "robot" / path.name).write_bytes(path.read_bytes())
    robot = yaml.safe_load((source / "robot.yaml").read_text())
    robot.pop("odometry", None)
    robot["range_sensor"]["reach_m"] = round(case.reach_m, 2)
    robot["errors"] |= {"wheel_radius_percent": case.wheels_percent, "slip_percent": case.wheels_percent}
    (folder / "robot" / "robot.yaml").write_text(yaml.safe_dump(robot))
    return RigFiles(folder / "world.yaml", folder / "map.yaml", folder / "places.yaml", {})


def _draw_crates(cells: np.ndarray, x: float, y: float) -> None:
    """Draw crates around a place at x, y in [m]; rows of `cells` are from the top."""
    half, rows = 0.5 * CRATE_M, cells.shape[0]
    for right, up in CRATES:
        low, high = (round((x + right + side) / CELL_M) for side in (-half, half))
        bottom, top = (rows - round((y + up + side) / CELL_M) for side in (-half, half))
        cells[top:bottom, max(0, low) : high] = 0


def moved_start(case: Case) -> Pose2:
    """Return the offset of the true start: none, or more than the stated start allows."""
    if not case.wrong_start:
        return Pose2(0.0, 0.0, 0.0)
    rng = np.random.default_rng([case.seed, 78])
    away, bearing = rng.uniform(*SHIFTED_M), rng.uniform(-math.pi, math.pi)
    turn = math.radians(rng.uniform(*TURNED_DEG)) * rng.choice([-1.0, 0.0, 1.0])
    y = max(-0.7, min(0.7, away * math.sin(bearing)))
    return Pose2(away * math.cos(bearing), y, float(turn))


def is_by_direction(case: Case) -> bool:
    """Return True if places allow a larger error along the corridor than across it."""
    return case.tolerance_mm > SUCCESS_LIMIT[0] and case.seed % 2 == 1


def truth_of(rig: Rig) -> Pose2:
    """world_T_base."""
    truth = rig.backend.ground_truth()
    assert truth is not None, "the backend is simulated"
    return truth.base


def drive(case: Case) -> list[Ended]:
    """Drive to both places; every outcome with what the ground truth says of it."""
    with tempfile.TemporaryDirectory() as name:
        files = make_files(case, Path(name))
        robot = str(Path(name) / "robot" / "robot.yaml")
        with build_rig(files, robot=robot, seed=case.seed, backend=case.backend) as rig:
            return list(_driven(rig, case))


def _driven(rig: Rig, case: Case) -> Iterator[Ended]:
    for place in ("middle", "far"):
        before = truth_of(rig)
        outcome = rig.do(MoveTo(place=place, wait_s=0.0))
        after = truth_of(rig)
        success = isinstance(outcome, Success)
        wanted = rig.model.places[place].pose if success else before
        off, turned = 1e3 * after.distance(wanted), math.degrees(after.turn(wanted))
        far, askew = (max(SUCCESS_LIMIT[0], case.tolerance_mm), SUCCESS_LIMIT[1]) if success else FAIL_LIMIT
        beside = success and is_by_direction(case) and 1e3 * abs(after.y - wanted.y) > SUCCESS_LIMIT[0]
        false = not isinstance(outcome, GiveUp) and (off > far or turned > askew or beside)
        yield Ended(type(outcome).__name__, getattr(outcome, "reason", ""), off, turned, false)
        if isinstance(outcome, GiveUp):
            return


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--runs", type=int, default=40)
    words.add_argument("--first", type=int, default=0, help="the first seed")
    words.add_argument("--backend", choices=["kinematic", "mujoco", "pybullet"], default="kinematic")
    words.add_argument("--pillars", action="store_true", help="a pillar on each side every 3 m")
    words.add_argument(
        "--hall",
        action="store_true",
        help=f"{HALL_M:g} m wide, with crates around its start, and around its end in every other run",
    )
    words.add_argument("--wrong-start", action="store_true", help="set down 0.4 to 1.5 m off, or turned")
    words.add_argument("--verbose", action="store_true", help="a line for each MOVE_TO")
    chosen = words.parse_args()
    counts: dict[str, int] = {}
    done, false, free, free_success, begun = 0, 0, 0, 0, time.process_time()
    with CutOff() as cut:  # report the runs until then
        for seed in range(chosen.first, chosen.first + chosen.runs):
            width = HALL_M if chosen.hall else CORRIDOR_M
            case = draw(seed, chosen.pillars, chosen.backend, chosen.wrong_start, width)
            print(f"\rrun {seed}, {case.length_m:.0f} m ...", end="", file=sys.stderr, flush=True)
            ended = drive(case)
            done += 1
            for item in ended:
                counts[item.outcome] = counts.get(item.outcome, 0) + 1
                false += item.false
                if item.false or chosen.verbose:
                    print(f"\r{json.dumps(case._asdict())}\n  {item}")
            if not case.pallet:
                free += 1
                free_success += all(item.outcome == "Success" for item in ended)
    seconds = time.process_time() - begun
    print(f"\r{done} runs, {counts}: {false} false Success or Fail; {seconds:.0f} CPU s")
    print(f"without a pallet: {free_success} of {free} runs reached both places")
    raise SystemExit(cut.status(not done or bool(false)))


if __name__ == "__main__":
    main()
