"""Drive through halls of several hectares: `python -m benchmarks.driving.large_maps [--sizes 50 100 200]`.

A hall has rows of racks 24 m long with aisles of 3.2 m, and a few pallets that no map shows. The cart drives
from one corner to near the opposite one (`far`), or to the last aisle there (`rack`). Printed for each size:
cells of the map; CPU time until the rig is built and until the first motion; CPU time of a period with its
simulation; most memory of the process so far; the outcome, and how far off it is by the ground truth. Status
1 after a false Success.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo

CELL_M, WALL_CELLS = 0.05, 2
RACK_M, AISLE_M, CROSS_M = (24.0, 1.2), 3.2, 4.0
PALLETS_PER_HA = 8.0
SUCCESS_MM = 40.0


class Measured(NamedTuple):
    """Times and outcome of one hall."""

    cells: int
    built_s: float
    first_s: float
    """CPU time from MOVE_TO's begin until the wheels are first driven."""
    periods_ms: list[float]
    outcome: str
    off_mm: float
    driven_s: float
    """Time on the robot's clock."""


def hall_of(side: float) -> np.ndarray:
    """Return a hall's occupied cells, (n, n), True at walls and racks."""
    count = round(side / CELL_M)
    solid = np.zeros((count, count), np.bool_)
    solid[:WALL_CELLS] = solid[-WALL_CELLS:] = True
    solid[:, :WALL_CELLS] = solid[:, -WALL_CELLS:] = True
    (length, depth), step = RACK_M, RACK_M[1] + AISLE_M
    for y in np.arange(CROSS_M, side - CROSS_M - depth, step):
        for x in np.arange(CROSS_M, side - CROSS_M - length, length + CROSS_M):
            rows = slice(round(y / CELL_M), round((y + depth) / CELL_M))
            solid[rows, round(x / CELL_M) : round((x + length) / CELL_M)] = True
    return solid


def write_hall(folder: Path, side: float, seed: int) -> RigFiles:
    """Write map, places and world of a hall."""
    solid = hall_of(side)
    Image.fromarray(np.where(solid, 0, 254).astype(np.uint8)[::-1]).save(folder / "map.png")
    (folder / "map.yaml").write_text(
        "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    rows = int((side - 2 * CROSS_M - RACK_M[1]) // (RACK_M[1] + AISLE_M))
    last_aisle = CROSS_M + rows * (RACK_M[1] + AISLE_M) - 0.5 * AISLE_M
    far = {"x_m": round(side - 12.0, 3), "y_m": round(last_aisle, 3), "heading_deg": 0.0}
    home = {"x_m": 2.0, "y_m": 2.0, "heading_deg": 0.0}
    beside = CROSS_M + RACK_M[0] + _last_rack(side) - 3.0
    rack = {"x_m": round(beside, 3), "y_m": round(last_aisle, 3), "heading_deg": 0.0}
    places = {"format": "handcart-places/1", "places": {"home": home, "far": far, "rack": rack}}
    (folder / "places.yaml").write_text(json.dumps(places))
    world: dict[str, object] = {"format": "handcart-world/1", "map": "map.yaml", "start": home}
    world["surprises"] = pallets_in(solid, side, seed)
    (folder / "world.yaml").write_text(yaml.safe_dump(world))
    return RigFiles(folder / "world.yaml", folder / "map.yaml", folder / "places.yaml", {})


def _last_rack(side: float) -> float:
    """Return the distance of the last column of racks from the first one, in [m]."""
    step = RACK_M[0] + CROSS_M
    return float(step * ((side - 2 * CROSS_M - RACK_M[0] - 1e-9) // step))


def pallets_in(solid: np.ndarray, side: float, seed: int) -> list[dict[str, object]]:
    """Return pallets beside the aisles' middles, that leave a way."""
    rng = np.random.default_rng(seed)
    found: list[dict[str, object]] = []
    wanted = round(PALLETS_PER_HA * (side / 100.0) ** 2)
    while len(found) < wanted:
        x, y = rng.uniform(6.0, side - 14.0, 2).tolist()
        row, column, room = round(y / CELL_M), round(x / CELL_M), round(0.7 / CELL_M)
        if not solid[row - room : row + room, column - room : column + room].any():
            pallet = {"name": f"pallet {len(found)}", "x_m": x, "y_m": y, "size_m": [0.8, 0.6, 0.5]}
            found.append(pallet)
    return found


def measure(side: float, seed: int, backend: str, goal: str) -> Measured:
    """Drive once through a hall."""
    with tempfile.TemporaryDirectory(prefix="large-maps-") as name:
        files = write_hall(Path(name), side, seed)
        begun = time.process_time()
        with build_rig(files, robot="cart", seed=seed, backend=backend) as rig:
            built, periods, first = time.process_time() - begun, [], [0.0]
            robot = rig.robot
            step, last, clock = robot.step, [time.process_time()], robot.time

            def timed(paused: bool = False) -> None:
                if first[0] == 0.0 and any(robot.command):
                    first[0] = time.process_time()
                step(paused)
                now = time.process_time()
                periods.append(1e3 * (now - last[0]))
                last[0] = now

            robot.step = timed  # type: ignore[method-assign]
            asked = time.process_time()
            outcome = rig.do(MoveTo(place=goal))
            truth = rig.backend.ground_truth()
            assert truth is not None, "the backend is simulated"
            off = 1e3 * truth.base.distance(rig.model.places[goal].pose)
            words = type(outcome).__name__ + (
                f": {reason}" if (reason := getattr(outcome, "reason", "")) else ""
            )
            cells = round(side / CELL_M) ** 2
            return Measured(cells, built, first[0] - asked, periods, words, off, robot.time - clock)


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--sizes", type=float, nargs="+", default=[50.0, 100.0, 200.0], help="sides in m")
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--backend", choices=["kinematic", "mujoco", "pybullet"], default="kinematic")
    words.add_argument(
        "--goal",
        choices=["far", "rack"],
        default="far",
        help="far: 12 m from the corner; rack: beside the last",
    )
    chosen = words.parse_args()
    false = 0
    for side in chosen.sizes:
        print(f"hall of {side:g} x {side:g} m ...", file=sys.stderr, flush=True)
        found = measure(side, chosen.seed, chosen.backend, chosen.goal)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        is_false = found.outcome == "Success" and found.off_mm > SUCCESS_MM
        false += is_false
        ranked = np.percentile(found.periods_ms, [50, 99, 100])
        print(
            f"{side:g} m, {found.cells / 1e6:.1f} M cells: built {found.built_s:.1f} s, "
            f"first motion {found.first_s:.2f} s, "
            f"a period {ranked[0]:.1f} ms, 99 % {ranked[1]:.1f}, most {ranked[2]:.0f} ms, "
            f"{memory:.0f} MB, {found.driven_s:.0f} s driven, {found.off_mm:.0f} mm off"
            f"{', FALSE' if is_false else ''}: {found.outcome[:160]}",
            flush=True,
        )
    raise SystemExit(1 if false else 0)


if __name__ == "__main__":
    main()
