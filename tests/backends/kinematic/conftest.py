"""A small room with one shelf, and a hand to move about in it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from tests.shelf_text import GAP, ROOM_WALLS, shelf_text

WORLD = f"""
format: handcart-world/1
start: {{x_m: 2.0, y_m: 1.2, heading_deg: 90}}
{ROOM_WALLS}furniture:
  - {{name: desk, x_m: 0.6, y_m: 0.6, heading_deg: 10, size_m: [0.6, 0.4, 0.75]}}
surprises:
  - {{name: passer-by, x_m: 3.4, y_m: 1.2, size_m: [0.4, 0.4, 1.7], appears_s: 1.0, leaves_s: 2.0}}
{shelf_text([101, 102, 103, GAP, 104, 105, 106])}"""

Make = Callable[..., Any]
"""Makes a `KinematicBackend`; tests look behind it, and know what the robot has."""


@pytest.fixture
def world(tmp_path: Path) -> WorldFile:
    path = tmp_path / "world.yaml"
    path.write_text(WORLD, encoding="utf-8")
    return load(path, world_model())


@pytest.fixture
def make(world: WorldFile) -> Make:
    return lambda seed=0: KinematicBackend(load_robot("librarian"), world, seed)


class Puppet:
    """Moves the hand of a docked robot on straight lines, upright and pointing forward."""

    DOCK = 0.47
    TIP = 0.15

    def __init__(self, backend: KinematicBackend) -> None:
        assert backend._arm is not None and backend._gripper is not None
        self.backend = backend
        self.scene: Any = backend.scene
        self.arm, self.gripper = backend._arm, backend._gripper
        self.scene.move_base(Pose2(2.0, 2.0 - self.DOCK, np.pi / 2))

    def to(self, x: float, y: float, z: float) -> None:
        joints = self.arm.command()
        model = self.scene.arm
        start = model.forward(joints)[:3, 3]
        goal = np.array([x, y, z])
        count = max(2, int(np.linalg.norm(goal - start) / 0.004))
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            near = model.inverse(transform(tuple(start + share * (goal - start))), joints, restarts=0)
            while not np.allclose(joints, near):
                joints = joints + np.clip(near - joints, -0.07, 0.07)
                self.arm.move(joints)
                self.backend.step()

    def fingers(self, width: float) -> None:
        self.gripper.move(width)
        for _ in range(35):
            self.backend.step()

    def take_book(self) -> None:
        spine = self.scene.of(BookProps).tray_book().base_T_thing[:3, 3]
        self.to(-0.10, spine[1], 0.80)
        self.to(-0.10, spine[1], 0.70)
        self.to(spine[0] - 0.12, spine[1], 0.70)
        self.fingers(0.0)

    @property
    def slot(self) -> float:
        """y of the gap's middle in the base frame: the shelf stands straight before the base."""
        return 0.2 - 0.13 - 0.0155

    def before_slot(self, error: float = 0.0) -> None:
        """Hand with the book in front of its slot, foot 4 mm above the board."""
        spine = self.scene.of(BookProps).tray_book().base_T_thing
        self.take_book()
        self.to(spine[0, 3] - 0.12, spine[1, 3], 0.80)
        self.to(0.0, self.slot + error, 0.80)
        self.to(0.10, self.slot + error, self.height)

    @property
    def height(self) -> float:
        return 0.784

    def insert(self, error: float = 0.0) -> None:
        self.before_slot(error)
        self.to(self.DOCK - 0.03 - 0.12, self.slot + error, self.height)


@pytest.fixture
def puppet(make: Make) -> Puppet:
    return Puppet(make())
