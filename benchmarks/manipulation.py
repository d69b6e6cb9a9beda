"""Times of the arm's mathematics on the librarian, one thread: `python benchmarks/manipulation.py`."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import plan_motion, plan_straight
from handcart.robotics.manipulation.motions.trajectory import time_path

ROBOT_FILE = Path(__file__).resolve().parents[1] / "backends" / "robots" / "librarian" / "librarian.urdf"
READY_POSTURE = np.array([-0.941, -0.9967, 2.3301, -0.9545, -1.4318, 0.1931])
PILLAR_BOX = Box(transform((0.3, 0.0, 1.1)), (0.05, 0.3, 0.6), "pillar")


def books(count: int) -> list[Box]:
    """Return a row of books on a shelf before the robot."""
    rows = np.linspace(-0.5, 0.5, count)
    return [Box(transform((0.545, y, 0.81)), (0.15, 0.9 / count, 0.22), f"book_{y:.3f}") for y in rows]


def report(name: str, work: Callable[[Any], object], inputs: Sequence[Any]) -> None:
    """Print one row: mean, median and 95 % of the time for one input, in [us], and the share of results."""
    times, results = [], []
    for one in inputs:
        begun = time.perf_counter()
        results.append(work(one))
        times.append(1e6 * (time.perf_counter() - begun))
    found = sum(result is not None for result in results)
    middle, high = np.percentile(times, [50, 95])
    print(f"{name:46s} {np.mean(times):10.1f} {middle:10.1f} {high:10.1f} {found:6d}/{len(inputs)}")


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    arm = ArmModel(ROBOT_FILE.read_text(), [f"joint_{number}" for number in range(1, 7)])
    rng = np.random.default_rng(1)
    postures = rng.uniform(arm.lower, arm.upper, (1000, 6))
    print(f"{'[us]':46s} {'mean':>10s} {'median':>10s} {'95 %':>10s} results")
    report("forward kinematics", arm.forward, list(postures))
    report("Jacobian", arm.jacobian, list(postures))
    near = [(arm.forward(q), q + rng.uniform(-0.1, 0.1, 6)) for q in postures]
    far = [(pose, other) for (pose, _), other in zip(near, rng.permutation(postures), strict=True)]
    report("inverse, near seed (0.1 rad)", lambda pair: arm.inverse(*pair), near)
    report("inverse, random seed", lambda pair: arm.inverse(*pair), far)
    held = Box(transform((0.2, 0.0, 0.0)), (0.16, 0.03, 0.2))
    for count in (0, 30, 100):
        collision = CollisionModel(arm, books(count), held=held)
        name = f"{count} books, {collision.pairs} pairs"
        report(f"collision check, {name}", collision.in_collision, list(postures))
        report(f"distance, {name}", collision.distance, list(postures[:200]))
    collision = CollisionModel(arm, [*books(30), PILLAR_BOX], margin=0.005)
    free = [q for q in postures if not collision.in_collision(q)][:101]
    pairs = list(pairwise(free))
    report(
        "plan_motion past a pillar and 30 books",
        lambda pair: plan_motion(arm, collision, pair[0], pair[1], seed=1),
        pairs,
    )
    line = plan_straight(arm, READY_POSTURE, transform((0.14, 0.42, 0.79)))
    report(
        "plan_straight, 0.5 m",
        lambda goal: plan_straight(arm, READY_POSTURE, goal),
        [transform((0.14, 0.42, 0.79))] * 20,
    )
    limits = (np.full(6, 1.5), np.full(6, 3.0), 0.05)
    report("time_path, that straight line", lambda path: time_path(path, *limits), [line] * 20)
    report("time_path, one joint line", lambda pair: time_path(np.array(pair), *limits), pairs)


if __name__ == "__main__":
    main()
