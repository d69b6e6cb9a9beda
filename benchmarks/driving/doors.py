"""Doors little wider than a rectangular footprint: `python -m benchmarks.driving.doors [--worlds N]`.

Two rooms with a wall between them that is turned by up to 30 degrees and has one door, `--room` wider than
the footprint of 0.5 x 0.43 m. Start, goal and door are drawn; the map shows everything, its cells lie
anywhere. `tasks/drive_map` drives there, as `handcart run` does it. A world counts as reached if the goal was
reached without a Fail. Status 1 if a contact or a false outcome happened.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks.cut_off import CutOff
from benchmarks.driving.cluttered import Trial, run_watched
from benchmarks.driving.cluttered_robot import write_robot
from benchmarks.driving.worlds.cluttered_worlds import Box, map_text, world_text
from handcart.files.errors import FileError
from handcart.networks.task.preparing import prepare
from handcart.robotics.navigation.maps.grid_map import from_boxes

TASK = Path(__file__).resolve().parents[2] / "tasks" / "drive_map" / "task.yaml"
SIDES = (0.5, 0.43)  # of the footprint, in [m]
LENGTH_M, WIDTH_M, WALL_M = 7.0, 4.4, 0.1  # of both rooms together
MAX_TURN_DEG = 30.0  # of the wall between the rooms
FROM_DOOR_M = (1.2, 2.2)  # along x, of start and goal
FROM_SIDE_M = 0.8  # of door, start and goal


class Doorway(NamedTuple):
    """Two rooms with a door between them."""

    seed: int
    walls: list[Box]
    start: tuple[float, float, float]
    """x, y in [m], heading in [deg]."""
    goal: tuple[float, float, float]


def make_doorway(seed: int, width: float) -> Doorway:
    """Return the rooms of a seed, with a door of `width` in [m]."""
    rng = np.random.default_rng([seed, 41])
    turn, y = math.radians(rng.uniform(-MAX_TURN_DEG, MAX_TURN_DEG)), rng.uniform(1.4, WIDTH_M - 1.4)
    middle = np.array([LENGTH_M / 2, y])
    along = np.array([-math.sin(turn), math.cos(turn)])
    walls: list[Box] = [(LENGTH_M / 2, side, 0.0, LENGTH_M + WALL_M, WALL_M) for side in (0.0, WIDTH_M)] + [
        (side, WIDTH_M / 2, 0.0, WALL_M, WIDTH_M + WALL_M) for side in (0.0, LENGTH_M)
    ]
    for sign, end in ((1.0, WIDTH_M - y), (-1.0, y)):
        length = end / math.cos(turn) - width / 2 + WALL_M * math.tan(abs(turn))
        x, across = (middle + sign * (width + length) / 2 * along).tolist()
        walls.append((x, across, turn, WALL_M, length))
    ends = [
        (
            float(middle[0] + sign * rng.uniform(*FROM_DOOR_M)),
            float(rng.uniform(FROM_SIDE_M, WIDTH_M - FROM_SIDE_M)),
            float(rng.uniform(-180.0, 180.0)),
        )
        for sign in (-1.0, 1.0)
    ]
    return Doorway(seed, walls, ends[0], ends[1])


def try_doorway(doorway: Doorway, chosen: argparse.Namespace) -> Trial:
    """Drive through a door."""
    result = Trial(doorway.seed, 0.0, best_m=math.dist(doorway.start[:2], doorway.goal[:2]))
    try:
        _drive(doorway, chosen, result)
    except FileError as wrong:
        result.outcome, result.reason = "refused", str(wrong)[:300]
    return result


def _drive(doorway: Doorway, chosen: argparse.Namespace, result: Trial) -> None:
    with TemporaryDirectory(prefix="doors-") as name:
        folder = Path(name)
        shift = np.random.default_rng([doorway.seed, 7]).uniform(-chosen.cell, 0.0, 2)
        corner = float(shift[0]) - 0.3, float(shift[1]) - 0.3
        grid = from_boxes(doorway.walls, chosen.cell, corner, (LENGTH_M + 0.7, WIDTH_M + 0.7))
        map_text(grid, folder)
        world_text(folder, doorway.walls, [], doorway.start, doorway.goal, (40.0, 1.0))
        robot = write_robot(folder, SIDES, chosen.speed, "scan", chosen.view)
        settings = {key: str(folder / f"{key}.yaml") for key in ("map", "world", "places")}
        settings |= {"robot": str(robot), "tour": "[goal]", "wait_s": "2"}
        with prepare(TASK, backend=chosen.backend, settings=settings, seed=doorway.seed) as prepared:
            run_watched(prepared, folder, result)
            scene = prepared.backend.scene  # type: ignore[attr-defined]
            result.contacts = len(scene.contacts)


def main() -> None:
    """Try the doors one after the other."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--worlds", type=int, default=100, help="number of worlds (default: 100)")
    words.add_argument("--first", type=int, default=0, metavar="SEED", help="seed of the first (default: 0)")
    words.add_argument("--room", type=float, default=0.1, help="of door over footprint, in m (default: 0.1)")
    words.add_argument("--speed", type=float, default=1.0, help="top speed in m/s (default: 1)")
    words.add_argument("--view", type=float, default=360.0, help="of the lidar, in deg (default: 360)")
    words.add_argument("--cell", type=float, default=0.05, help="of the map, in m (default: 0.05)")
    words.add_argument("--backend", default="kinematic", help="kinematic (default), mujoco, pybullet")
    chosen = words.parse_args()
    width = SIDES[1] + chosen.room
    print(f"{chosen.worlds} doors of {width:.2f} m, footprint {SIDES[0]} x {SIDES[1]} m", flush=True)
    results = []
    with CutOff() as cut:  # report the runs until then
        for seed in range(chosen.first, chosen.first + chosen.worlds):
            result = try_doorway(make_doorway(seed, width), chosen)
            results.append(result)
            print(
                f"door {seed}: {result.outcome}, {result.fails} Fails, {result.seconds:.1f} s, "
                f"{result.contacts} contacts, nearest {result.nearest_mm:.0f} mm"
                + ("" if result.reached else f"; {result.reason}"),
                flush=True,
            )
    reached, contacts = sum(item.reached for item in results), sum(item.contacts for item in results)
    false = sum(len(item.false) for item in results)
    seconds = np.nanmedian([item.seconds for item in results])
    print(
        f"{len(results)} doors: {reached} reached without a Fail "
        f"({100.0 * reached / max(1, len(results)):.1f} %); "
        f"false outcomes {false}; contacts {contacts}; worlds touched "
        f"{sum(item.contacts > 0 for item in results)}; nearest "
        f"{min(item.nearest_mm for item in results):.1f} mm; median {seconds:.1f} s"
    )
    raise SystemExit(cut.status(not results or any(item.contacts or item.false for item in results)))


if __name__ == "__main__":
    main()
