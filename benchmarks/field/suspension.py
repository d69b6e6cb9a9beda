"""Measure how much rough ground the El-Verde's rockers with their differential absorb.

python -m benchmarks.field.suspension [--backend mujoco|pybullet] [--seeds N] [--metres M]

It drives straight ahead over the ground of the field test, 2.5 degrees rough. Tilt is the body's, to
level; a side's is the inclination of its two wheels, which the body would have if that side alone carried
it. A wheel hangs if it is 15 mm over the ground. "rigid" has the rockers' joints fixed.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from handcart.backends.physics.body.physics_car import FRONT, REAR
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.networks.task.preparing import prepare
from handcart.robotics.numerics.arrays import FloatArray

TASK_FILE = Path(__file__).parent.parent.parent / "tasks" / "deploy_straight" / "task.yaml"
ROBOT_FOLDER = Path(__file__).parent.parent.parent / "backends" / "robots" / "el_verde"
SPEED_M_S = 0.4  # [m/s]
WHEEL_RADIUS_M = 0.15  # [m] of its wheels
HANGING_HEIGHT_M = 0.015  # [m] of a wheel over the ground below its middle


class Drive(NamedTuple):
    """One drive, in each period of it."""

    tilts: list[float]
    """Tilts of the body [rad]."""
    sides: list[float]
    """Inclinations of the sides [rad]."""
    hanging: list[int]
    """Wheels that hang."""


def rigid(folder: Path) -> str:
    """Return the robot's file, its rockers' joints fixed."""
    urdf = (ROBOT_FOLDER / "el_verde.urdf").read_text(encoding="utf-8")
    for side in ("left", "right"):
        urdf = urdf.replace(f'"{side}_rocker" type="revolute"', f'"{side}_rocker" type="fixed"')
    urdf = urdf.replace('<mimic joint="left_rocker"/>', "")
    (folder / "el_verde.urdf").write_text(urdf, encoding="utf-8")
    text = (ROBOT_FOLDER / "robot.yaml").read_text(encoding="utf-8")
    (folder / "robot.yaml").write_text(text, encoding="utf-8")
    return str(folder / "robot.yaml")


def drive(robot: str, backend: str, seed: int, metres: float) -> Drive:
    """Straight ahead."""
    driven = Drive([], [], [])
    with prepare(TASK_FILE, backend, {"robot": robot}, seed) as prepared:
        physics = prepared.backend
        assert isinstance(physics, PhysicsBackend)
        body = physics._body
        for _ in range(round(metres / SPEED_M_S / physics.period)):
            prepared.robot.base.drive(SPEED_M_S, 0.0)
            prepared.robot.step()
            driven.tilts.append(math.acos(min(1.0, float(body.base_pose()[2, 2]))))
            for rear, front in zip(REAR, FRONT, strict=True):
                along = body.link_pose(front)[:3, 3] - body.link_pose(rear)[:3, 3]
                driven.sides.append(math.atan2(float(along[2]), math.hypot(*along[:2].tolist())))
            feet = np.array([body.link_pose(name)[:3, 3] for name in (*REAR, *FRONT)]) - (
                0.0,
                0.0,
                WHEEL_RADIUS_M,
            )
            ground = [physics.scene.ground_height(x, y) for x, y in feet[:, :2].tolist()]
            driven.hanging.append(int((feet[:, 2] > np.array(ground) + HANGING_HEIGHT_M).sum()))
    return driven


def _rms(values: FloatArray) -> float:
    return math.degrees(math.sqrt(float(np.mean(np.square(values)))))


def main() -> None:
    """See above."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--backend", default="mujoco")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--metres", type=float, default=20.0)
    asked = parser.parse_args()
    print(f"{'':10}{'tilt, RMS':>12}{'most':>10}{'a side, RMS':>14}{'time on 4 wheels':>19}")
    with tempfile.TemporaryDirectory() as folder:
        for name, robot in (("rockers", "el_verde"), ("rigid", rigid(Path(folder)))):
            drives = [drive(robot, asked.backend, seed, asked.metres) for seed in range(asked.seeds)]
            tilts = np.concatenate([item.tilts for item in drives])
            sides = np.concatenate([item.sides for item in drives])
            hanging = np.concatenate([item.hanging for item in drives])
            most, four = math.degrees(tilts.max()), 100.0 * float(np.mean(hanging == 0))
            print(f"{name:10}{_rms(tilts):8.2f} deg{most:6.1f} deg{_rms(sides):10.2f} deg{four:17.1f} %")


if __name__ == "__main__":
    main()
