"""Joints that mimic others, on all simulated backends: `python -m benchmarks.robots.mimics [--robots N]`.

Random trees of revolute, prismatic and continuous joints on a mobile base. Half of the joints follow another
one, with a multiplier of -3 to 2 and an offset; they are nearer to the base than their leader, on another
branch, or carried by it, and their names sort before or after. The arm moves to a random posture and comes to
rest. Measured are the error of each link's pose against the tree multiplied out, and how far the arm's joints
are behind their command while they move, also of the same robot whose followers are fixed. Exit status 1
where a link is off by more than the limit, or joints lag more than without followers.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.robots.mimic_robots import MimicRobot
from handcart.backends.capabilities.arm import Arm
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import backend_class
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.manipulation.motions.trajectory import time_path

MAX_LINK_ERROR = 1e-4
"""[m] and [rad] that a link may be off at rest."""
LAG_SHARE, LAG_ADDED = 1.5, 5e-3
"""Times, and more than that in [rad] or [m], that joints may lag compared to those without followers."""
SETTLE_PERIODS = 40
EMPTY_WORLD = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}}


class Moved(NamedTuple):
    """One motion of a robot."""

    off: float
    """Largest error of a link's pose at rest, in [m] and [rad]."""
    lag: float
    """Largest distance of a joint from its command while it moves, in [rad] or [m]."""
    worst: str
    """The link that is off."""


def move(robot: MimicRobot, name: str, seed: int) -> Moved:
    """Move a robot to a posture on a backend, and hold it against the tree multiplied out."""
    with tempfile.TemporaryDirectory() as folder:
        spec = load_robot(str(robot.write(Path(folder))))
        backend: Any = backend_class(name)(spec, world_model().model_validate(EMPTY_WORLD), 0)  # type: ignore[call-arg]
    try:
        arm, goal = backend.get(Arm), robot.goal(seed)
        speed, acceleration = spec.joint_speeds(), spec.joint_accelerations()
        path = time_path(np.array([np.zeros(len(goal)), goal]), speed, acceleration, backend.period)
        lag = 0.0
        for joints in (*path[1:], *[goal] * SETTLE_PERIODS):
            arm.move(joints)
            backend.step()
            lag = max(lag, float(np.abs(arm.joints() - joints).max()))
        off, worst = _off(robot, backend, spec, goal)
        return Moved(off, lag, worst)
    finally:
        backend.close()


def _off(robot: MimicRobot, backend: Any, spec: Any, goal: Any) -> tuple[float, str]:
    expected = robot.link_poses(goal)
    if backend.name == "kinematic":
        model = spec.arm_model()
        found = {name: model.forward(backend.scene.joints, _shown(name)) for name in expected}
    else:
        base = inverse(backend.link_pose("base"))
        found = {name: base @ backend.link_pose(_shown(name)) for name in expected}
    off = {name: float(np.abs(found[name] - expected[name]).max()) for name in expected}
    worst = max(off, key=lambda name: off[name])
    return off[worst], worst


def _shown(name: str) -> str:
    """Return the name of a link in the robot's file: the last leader's is the hand."""
    return "hand" if name == "lead_2" else name


def main() -> None:
    """Print a table; status 1 where a limit is broken."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--robots", type=int, default=30, help="how many")
    words.add_argument("--seed", type=int, default=0, help="of the first")
    words.add_argument("--backends", nargs="+", default=["kinematic", "mujoco", "pybullet"], metavar="NAME")
    chosen = words.parse_args()
    say, wrong = Console(stderr=True), 0
    table = Table("backend", "robots", "link off at rest, most", "lag, most", "without followers", box=None)
    for name in chosen.backends:
        rows = []
        for seed in range(chosen.seed, chosen.seed + chosen.robots):
            with_mimics = move(MimicRobot(seed), name, seed)
            without = move(MimicRobot(seed, mimics=False), name, seed) if name != "kinematic" else with_mimics
            rows.append((with_mimics, without))
            far = with_mimics.off > MAX_LINK_ERROR
            late = with_mimics.lag > LAG_SHARE * without.lag + LAG_ADDED
            wrong += far or late
            if far or late:
                what = f"{with_mimics.worst} is off by {with_mimics.off:.2g}, lag {with_mimics.lag:.2g}"
                say.print(f"{name}, robot {seed}: {what} (without followers {without.lag:.2g})")
        off, lag, least = (max(item) for item in zip(*((a.off, a.lag, b.lag) for a, b in rows), strict=True))
        table.add_row(name, str(len(rows)), f"{off:.2g}", f"{lag:.2g}", f"{least:.2g}")
    Console().print(table)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
