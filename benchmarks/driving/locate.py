"""LOCATE from random starts on many maps, judged by the ground truth: python -m benchmarks.driving.locate

A run is right where LOCATE is a Success and the pose is true within 0.15 m and 5 degrees; wrong where it is
a Success and is not; ambiguous where it is a Fail. A Fail is false where the base is over 45 mm or 2 degrees
from where it began. With --boxes, things that no map shows stand around the robot.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.cut_off import CutOff
from benchmarks.driving.worlds.map_starts import Chart, chosen_charts, start_options, written_world
from handcart.evaluation.trials.rig import build_rig
from handcart.primitives.driving.locate import Locate
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.geometry.pose2 import Pose2

RIGHT_M, RIGHT_DEG = 0.15, 5.0
RESTORED_MM, RESTORED_DEG = 45.0, 2.0
KINDS = ("right", "wrong", "ambiguous", "gave up", "false Fail")


class Located(NamedTuple):
    """Result of one LOCATE."""

    kind: str
    """One of `KINDS`."""
    reason: str
    off_m: float
    looks: int
    driven_m: float
    time_s: float
    contacts: int


def locate_once(
    chart: Chart, seed: int, boxes: int = 0, backend: str = "kinematic", robot: str = "cart"
) -> Located:
    """Set a robot down on a map and let it find out where."""
    rng = np.random.default_rng([seed, 41])
    start = chart.pose(rng)
    with tempfile.TemporaryDirectory() as folder:
        files = written_world(Path(folder), chart, start, surprises=_boxes(rng, start, boxes))
        with build_rig(files, robot, backend, seed, is_start_known=False) as rig:
            before = rig.backend.ground_truth()
            primitive = Locate()
            outcome = rig.do(primitive)
            after = rig.backend.ground_truth()
            assert before is not None
            assert after is not None
            pose, passed = rig.robot.pose, rig.robot.time
    off, turned = after.base.distance(pose), math.degrees(after.base.turn(pose))
    kind = "gave up"
    if isinstance(outcome, Success):
        kind = "right" if off <= RIGHT_M and turned <= RIGHT_DEG else "wrong"
    elif isinstance(outcome, Fail):
        away = 1e3 * after.base.distance(before.base), math.degrees(after.base.turn(before.base))
        kind = "ambiguous" if away[0] <= RESTORED_MM and away[1] <= RESTORED_DEG else "false Fail"
    facts = primitive.facts
    looks, driven = int(facts.get("looks", 0)), float(facts.get("driven_m", 0.0))
    contacts = after.bumps - before.bumps
    return Located(kind, getattr(outcome, "reason", ""), off, looks, driven, passed, contacts)


def _boxes(rng: np.random.Generator, start: Pose2, count: int) -> list[dict[str, Any]]:
    """Return boxes that no map shows, clear of the robot."""
    made = []
    for number in range(count):
        away, bearing = rng.uniform(1.2, 4.0), rng.uniform(-math.pi, math.pi)
        size = [round(float(side), 3) for side in rng.uniform(0.2, 0.8, 2)]
        x, y = start.x + away * math.cos(bearing), start.y + away * math.sin(bearing)
        pose = {"x_m": round(x, 3), "y_m": round(y, 3), "heading_deg": round(float(rng.uniform(0, 180)), 1)}
        made.append({"name": f"box {number}", **pose, "size_m": [*size, 0.8]})
    return made


def main() -> None:
    words = start_options(__doc__, 300)
    words.add_argument("--boxes", type=int, default=0, help="things around the robot that no map shows")
    chosen = words.parse_args()
    begun, total = time.process_time(), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        every = chosen_charts(Path(folder), chosen)
        counts = {chart.name: Counter[str]() for chart in every}
        contacts, driven = 0, []
        with CutOff() as cut:  # report the runs until then
            for number in range(chosen.runs):
                chart, seed = every[number % len(every)], chosen.first + number
                print(
                    f"\rrun {number}, seed {seed}, {chart.name} ...   ", end="", file=sys.stderr, flush=True
                )
                found = locate_once(chart, seed, chosen.boxes, chosen.backend, chosen.robot)
                counts[chart.name][found.kind] += 1
                total[found.kind] += 1
                contacts += found.contacts
                driven.append(found.driven_m)
                if found.kind != "right" and (chosen.verbose or found.kind in ("wrong", "false Fail")):
                    print(f"\r{chart.name}, seed {seed}: {found}")
    for name, kinds in counts.items():
        print(f"\r{name}: " + ", ".join(f"{kinds[kind]} {kind}" for kind in KINDS if kinds[kind]))
    shares = ", ".join(f"{total[kind]} {kind}" for kind in KINDS)
    print(f"{total.total()} starts: {shares}; {100 * total['right'] / max(1, total.total()):.1f} % right")
    seconds = time.process_time() - begun
    print(f"contacts {contacts}, driven {np.mean(driven or [0.0]):.1f} m on average; {seconds:.0f} CPU s")
    raise SystemExit(cut.status(not driven or bool(total["wrong"] or total["false Fail"])))


if __name__ == "__main__":
    main()
