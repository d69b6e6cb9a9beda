"""A robot on the kinematic backend in a small world, with what it knows of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from backends.registry import make_backend
from backends.robot import Robot
from backends.robot_file import load_robot
from primitives.action_primitive import ActionPrimitive
from primitives.attempt import attempt
from primitives.knowledge import Catalogue, Place, Shelf
from primitives.outcome import Outcome
from primitives.world_model import WorldModel
from robotics.navigation.grid_map import Box, from_boxes

WORLD = """\
format: handcart-world/1
start: {x_m: 1.0, y_m: 1.0, heading_deg: 90}
walls:
  - {from_m: [0, 0], to_m: [8, 0]}
  - {from_m: [8, 0], to_m: [8, 6]}
  - {from_m: [8, 6], to_m: [0, 6]}
  - {from_m: [0, 6], to_m: [0, 0]}
furniture:
  - {name: desk, x_m: 3, y_m: 3, heading_deg: 0, size_m: [1.2, 1.6, 0.75]}
shelves:
  - name: shelf_1
    x_m: 6.5
    y_m: 5.4
    heading_deg: 90
    books:
      - {accession: 3, call: "512.2 ABE", thickness_mm: 25, height_mm: 210, depth_mm: 150}
"""
MAPPED = (
    Box(4.0, 0.0, 0.0, 8.1, 0.1),
    Box(4.0, 6.0, 0.0, 8.1, 0.1),
    Box(0.0, 3.0, 0.0, 0.1, 6.1),
    Box(8.0, 3.0, 0.0, 0.1, 6.1),
    Box(3.0, 3.0, 0.0, 1.2, 1.6),
    Box(6.5, 5.525, 0.0, 1.04, 0.25),
)
HOME = Place(x_m=1.0, y_m=1.0, heading_deg=90.0)
SHELF = Place(
    x_m=6.5,
    y_m=4.93,
    heading_deg=90.0,
    shelf=Shelf(distance_m=0.47, width_m=1.0, board_m=0.7, front_m=1.04),
)


@dataclass
class Rig:
    """A robot, what it knows, and its simulated world's truth (for tests alone)."""

    robot: Robot
    model: WorldModel
    scene: Any
    restored: list[str] = field(default_factory=list)

    def run(self, primitive: ActionPrimitive) -> Outcome:
        """One attempt to its outcome."""
        periods = attempt(primitive, self.robot, self.model, self.restored.append)
        while True:
            try:
                next(periods)
            except StopIteration as end:
                outcome: Outcome = end.value
                return outcome
            self.robot.step()


@pytest.fixture
def make_rig(tmp_path: Path) -> Callable[..., Rig]:
    """Builds a rig: more lines for the world's file, a seed."""

    def make(more: str = "", seed: int = 0, walls: tuple[Box, ...] = ()) -> Rig:
        world = tmp_path / "world.yaml"
        world.write_text(WORLD + more, encoding="utf-8")
        spec = load_robot("librarian")
        backend = make_backend("kinematic", spec, world, seed)
        grid = from_boxes(MAPPED + walls, 0.02, (-0.3, -0.3), (8.6, 6.6))
        catalogue = Catalogue(format="handcart-catalogue/1", books=())
        model = WorldModel(grid, {"home": HOME, "shelf_1": SHELF}, catalogue, np.empty((0, 2)))
        return Rig(Robot(backend, spec, HOME.pose, grid), model, backend.scene)  # type: ignore[attr-defined]

    return make
