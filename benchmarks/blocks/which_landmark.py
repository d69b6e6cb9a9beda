"""Whether FIXATE takes the right one of landmarks that look alike.

python -m benchmarks.blocks.which_landmark [TRIALS [PLAN ...]]

In each trial the base stands off as far as the robot believes it may (sigma 50 mm, 35 mrad), and FIXATE looks
at a random landmark of a plan. "right": it found where the base stands; "said": it failed, in words; "wrong":
Success, and the base is elsewhere. Then the same with a landmark of the plan covered, with one too many where
the plan would go on, and with the landmark covered that is looked for. PLAN is a part of a plan's name.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track
from ruamel.yaml import YAML

from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.networks.task.task_file import load_task
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

TASK_FOLDER = Path(__file__).parents[2] / "tasks" / "stack_blocks"
LANDMARK_HEIGHT_M = 0.4
PLAN_CENTRE_M = (4.27, 1.80)  # of the plans, on the table
POSE_SIGMA = (0.05, 0.05, 0.035)  # [m], [m], [rad]
RIGHT_MM = 6.0  # the base leans
ROBOT_NAME = "toyama/h1"

Fault = Literal["", "one covered", "one too many", "it is covered"]
LANDMARK_FAULTS: tuple[Fault, ...] = ("", "one covered", "one too many", "it is covered")


class Plan(NamedTuple):
    """Positions of landmarks on a map."""

    places: FloatArray
    """(n, 2) on the map, in [m]."""
    next: tuple[float, float]
    """Position of one more landmark that would continue the pattern [m]."""


def _lattice(columns: int, rows: int, across: float, along: float) -> Plan:
    """Rows along y."""
    x, y = ((np.arange(n) - (n - 1) / 2) * step for n, step in ((columns, across), (rows, along)))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2) + PLAN_CENTRE_M
    return Plan(grid, (float(grid[-1, 0]), float(grid[-1, 1] + along)))


def _irregular(seed: int, count: int = 9) -> Plan:
    """Anywhere, 75 mm apart or more."""
    rng, places = np.random.default_rng(seed), np.empty((0, 2))
    while len(places) <= count:
        one = rng.uniform((-0.15, -0.2), (0.15, 0.25)) + PLAN_CENTRE_M
        if len(places) == 0 or np.hypot(*(places - one).T).min() > 0.075:
            places = np.vstack([places, one])
    x, y = places[-1].tolist()
    return Plan(places[:-1], (x, y))


SHIPPED_PLAN = Plan(np.array([[4.18, 1.80], *([4.27, 1.63 + 0.09 * n] for n in range(5))]), (4.27, 2.08))
TRIED_PLANS = {
    "beside each goal (shipped)": SHIPPED_PLAN,
    "a row of 7, 75 mm apart": _lattice(1, 7, 0.0, 0.075),
    "a row of 4, 110 mm apart": _lattice(1, 4, 0.0, 0.11),
    "two rows of 4, 80 x 100 mm": _lattice(2, 4, 0.1, 0.08),
    "3 x 3, 90 mm apart": _lattice(3, 3, 0.09, 0.09),
    "9 anywhere": _irregular(1),
    "a pair, 70 mm apart": _lattice(1, 2, 0.0, 0.07),
}


def trial(plan: Plan, fault: Fault, seed: int, folder: Path) -> str:
    """One FIXATE: right, wrong, or why it failed."""
    rng = np.random.default_rng(seed)
    off = Pose2(*rng.normal(0.0, POSE_SIGMA).tolist())
    wanted, other = rng.choice(len(plan.places), 2, replace=False).tolist()
    gone = {"one covered": other, "it is covered": wanted}.get(fault)
    there = [tuple(place) for i, place in enumerate(plan.places.tolist()) if i != gone]
    there += [plan.next] if fault == "one too many" else []
    files = _written(plan.places.tolist(), there, folder)
    with build_rig(files, robot=ROBOT_NAME, seed=seed) as rig:
        scene = simulated_world(rig.backend)
        assert scene is not None
        scene.move_base(rig.model.places["stacking"].pose.compose(off))
        outcome = rig.do(Fixate(landmark=f"mark_{wanted}"))
        if not isinstance(outcome, Success):
            return str(outcome.reason)
        fixed = rig.model.of(Blocks).fixed
        return "right" if fixed and 1e3 * fixed.pose.distance(scene.base) < RIGHT_MM else "wrong"


def _written(planned: Sequence[Sequence[float]], there: Sequence[Sequence[float]], folder: Path) -> RigFiles:
    """Return the task's hall and table with other landmarks, and a plan of them."""
    yaml = YAML()
    world = yaml.load(TASK_FOLDER / "unload_world.yaml")
    world["marks"] = [_mark(at) for at in there]
    building = yaml.load(TASK_FOLDER / "building.yaml")
    building["landmarks"] = {f"mark_{i}": _mark(at) | {"place": "stacking"} for i, at in enumerate(planned)}
    yaml.dump(world, folder / "world.yaml")
    yaml.dump(building, folder / "building.yaml")
    return replace(
        RigFiles.of(load_task(TASK_FOLDER / "unload.yaml")),
        world=folder / "world.yaml",
        knowledge={"building": folder / "building.yaml"},
    )


def _mark(at: Sequence[float]) -> dict[str, float | str]:
    return {"x_m": round(at[0], 4), "y_m": round(at[1], 4), "height_m": LANDMARK_HEIGHT_M}


def main() -> None:
    """Print the table."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("trials", nargs="?", type=int, default=20)
    words.add_argument("plan", nargs="*", help="parts of plans' names; default: all")
    wanted = words.parse_args()
    count = wanted.trials
    print(f"{'plan':30}{'fault':16}{'right':>6}{'said':>6}{'wrong':>6}")
    chosen = {
        name: plan for name, plan in TRIED_PLANS.items() if any(word in name for word in wanted.plan or [""])
    }
    for name, plan in chosen.items():
        for fault in LANDMARK_FAULTS:
            with tempfile.TemporaryDirectory() as folder:
                seeds = track(range(count), f"{name}, {fault}", console=Console(stderr=True), transient=True)
                ends = Counter(trial(plan, fault, seed, Path(folder)) for seed in seeds)
            right, wrong = ends.pop("right", 0), ends.pop("wrong", 0)
            print(f"{name:30}{fault:16}{right:6}{ends.total():6}{wrong:6}", flush=True)
            for reason, times in sorted(ends.items()):
                print(f"    {times} x {reason}")


if __name__ == "__main__":
    main()
