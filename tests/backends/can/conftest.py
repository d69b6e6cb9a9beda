"""The cart on simulated drives."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from can.interfaces import virtual

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.world_files.world_model import world_model

ROOM: dict[str, Any] = {
    "format": "handcart-world/1",
    "start": {"x_m": 2.0, "y_m": 1.5, "heading_deg": 90.0},
    "walls": [
        {"from_m": [0, 0], "to_m": [4, 0]},
        {"from_m": [4, 0], "to_m": [4, 3]},
        {"from_m": [4, 3], "to_m": [0, 3]},
        {"from_m": [0, 3], "to_m": [0, 0]},
    ],
}
COUNTS_PER_M = 16384 * 20 / (2 * math.pi * 0.1)
"""Counts per metre of the cart's wheels."""
LEFT, RIGHT = 1, 2
"""Nodes of the cart's drives."""
Make = Callable[..., Any]
"""Makes a `CanBackend`; tests look behind it, and know what the robot has."""


@pytest.fixture(scope="session")
def cart() -> RobotFile:
    return load_robot("cart")


@pytest.fixture(scope="session")
def robot() -> RobotFile:
    return load_robot("librarian")


@pytest.fixture
def make(cart: RobotFile) -> Iterator[Make]:
    """Makes backends in a room (`room=False`: in none) and sees to it that nothing of them is left."""
    made, threads = [], threading.active_count()

    def build(seed: int = 0, room: bool = True, robot: RobotFile = cart) -> CanBackend:
        assert robot.can is not None
        inner = KinematicBackend(robot, world_model().model_validate(ROOM), seed) if room else None
        bench = Bench(robot, robot.can, inner)
        try:
            made.append(CanBackend(robot, bench))
        except Exception:
            bench.close()
            raise
        return made[-1]

    yield build
    for backend in made:
        backend.close()
    assert virtual.channels == {}
    assert threading.active_count() <= threads
