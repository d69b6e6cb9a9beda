"""Measure the cost of the PyBullet backend beyond Bullet itself: `python -m benchmarks.pybullet_backend`.

A run of whole control periods (drives, noise, contacts and ground truth included) while the robot drives
and moves its arm, against the time spent in `stepSimulation` within it: the same bodies in the same
states. No pictures are taken: they are rendered only on demand.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.pybullet.bullet_engine import BulletEngine
from handcart.backends.pybullet.pybullet_backend import PyBulletBackend
from handcart.backends.simulation.world_files.load_world import load_world

WORLD_FILE = Path(__file__).resolve().parents[1] / "tasks" / "return_book" / "world.yaml"
PERIODS, ROUNDS = 100, 9


class Clock:
    """Adds up how long a function takes."""

    def __init__(self, function: Callable[..., None]) -> None:
        self._function, self.spent = function, 0.0

    def __call__(self, *how: Any) -> None:
        began = time.perf_counter()
        self._function(*how)
        self.spent += time.perf_counter() - began


def main() -> None:
    """Print the ratio, and how many times faster than real time both are."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    backend = PyBulletBackend(load_robot("librarian"), load_world(WORLD_FILE), 0)
    engine: Any = backend._engine
    base, arm = backend.capabilities()[:2]
    assert isinstance(base, Base)
    assert isinstance(arm, Arm)
    posture, simulated = arm.command(), PERIODS * backend.period
    whole, inside = [], []
    for _ in range(ROUNDS):
        engine.step = clock = Clock(BulletEngine.step.__get__(engine))
        began = time.perf_counter()
        for number in range(PERIODS):
            base.drive(0.1 if number < PERIODS / 2 else -0.1, 0.0)
            arm.move(posture + 0.1 * np.sin(2 * np.pi * number / PERIODS))
            backend.step()
        whole.append(time.perf_counter() - began)
        inside.append(clock.spent)
    backend.close()
    for name, item in (("backend", whole), ("bare PyBullet", inside)):
        spent = np.median(item)
        print(
            f"{name:14s} {spent / PERIODS * 1e3:6.2f} ms a period, {simulated / spent:5.1f} times real time"
        )
    print(f"ratio {np.median(np.divide(whole, inside)):.3f} (median of {ROUNDS} rounds)")


if __name__ == "__main__":
    main()
