"""Measure the cost of a period in each physics engine: `python -m benchmarks.physics_backends [PERIODS]`.

The librarian drives and moves its arm beside 0, 10 and 40 loose boxes on a table, awake or asleep as the
engine decides. Both engines are in one process and alternate, so that load affects both alike. CPU time of
a whole period (drives, noise, contacts, ground truth) and of a step of the solver in it; medians over
rounds.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.registry import backend_class
from handcart.backends.simulation.world_files.world_model import world_model

ENGINE_NAMES = ("mujoco", "pybullet")
BOXES, ROUNDS, PERIODS = (0, 10, 40), 7, 20


class Clock:
    """Adds up how long a function takes."""

    def __init__(self, function: Callable[..., None]) -> None:
        self._function, self.spent = function, 0.0

    def __call__(self, *how: Any) -> None:
        began = time.process_time()
        self._function(*how)
        self.spent += time.process_time() - began


def main() -> None:
    """Print a table."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("periods", nargs="?", type=int, default=PERIODS)
    periods = words.parse_args().periods
    print("loose boxes  engine     ms a period   us a step   wrapper")
    for boxes in BOXES:
        backends = {name: _build(name, boxes) for name in ENGINE_NAMES}
        spent: dict[str, list[tuple[float, float]]] = {name: [] for name in ENGINE_NAMES}
        for _ in range(ROUNDS):
            for name, backend in backends.items():
                spent[name].append(_round(backend, periods))
        medians = {name: np.median(group, axis=0) for name, group in spent.items()}
        for name, (whole, inside) in medians.items():
            engine = backends[name]._engine
            steps = periods * engine.chunks * engine.substeps
            print(
                f"{boxes:11d}  {name:9s}  {1e3 * whole / periods:11.2f}  {1e6 * inside / steps:10.0f}  "
                f"{whole / inside:8.2f}"
            )
        ratio = medians["pybullet"] / medians["mujoco"]
        print(f"{boxes:11d}  pybullet/mujoco: period {ratio[0]:.2f}, step {ratio[1]:.2f}")
        for backend in backends.values():
            backend.close()


def _build(name: str, boxes: int) -> PhysicsBackend:
    world: dict[str, Any] = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}}
    world["tables"] = [
        {"name": "table", "x_m": 3.0, "y_m": 0.0, "size_m": [1.0, 1.0, 0.4], "foot_m": [0.3, 0.3]}
    ]
    world["blocks"] = [
        {"name": str(n), "x_m": 2.6 + 0.1 * (n % 8), "y_m": -0.3 + 0.12 * (n // 8), "height_m": 0.4}
        for n in range(boxes)
    ]
    kind = backend_class(name)
    assert issubclass(kind, PhysicsBackend)
    return kind(load_robot("librarian"), world_model().model_validate(world), 0)


def _round(backend: PhysicsBackend, periods: int) -> tuple[float, float]:
    """CPU time in [s] of these periods, and of the engine's steps in them."""
    engine: Any = backend._engine
    engine.step = clock = Clock(type(engine).step.__get__(engine))
    base, arm = backend.capabilities()[:2]
    posture = arm.command()  # type: ignore[attr-defined]
    began = time.process_time()
    for number in range(periods):
        base.drive(0.1 if number < periods / 2 else -0.1, 0.0)  # type: ignore[attr-defined]
        arm.move(posture + 0.05 * np.sin(2 * np.pi * number / periods))  # type: ignore[attr-defined]
        backend.step()
    return time.process_time() - began, clock.spent


if __name__ == "__main__":
    main()
