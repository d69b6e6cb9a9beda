"""A small room with one shelf in a physics engine, each of them, and a hand to move about in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.registry import backend_class
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from tests.shelf_text import GAP, ROOM_WALLS, shelf_text

WORLD = f"""
format: handcart-world/1
start: {{x_m: 2.0, y_m: 1.2, heading_deg: 90}}
{ROOM_WALLS}furniture:
  - {{name: desk, x_m: 0.6, y_m: 0.6, heading_deg: 10, size_m: [0.6, 0.4, 0.75]}}
{shelf_text([101, 102, GAP, 104, 105])}"""

Make = Callable[..., PhysicsBackend]


@pytest.fixture(params=["mujoco", "pybullet"])
def physics(request: pytest.FixtureRequest) -> type[PhysicsBackend]:
    """The class of a backend."""
    if request.param == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    kind = backend_class(request.param)
    assert issubclass(kind, PhysicsBackend)
    return kind


@pytest.fixture
def world(tmp_path: Path) -> WorldFile:
    path = tmp_path / "world.yaml"
    path.write_text(WORLD, encoding="utf-8")
    return load(path, world_model())


@pytest.fixture
def spec() -> RobotFile:
    return load_robot("librarian")


@pytest.fixture
def make(physics: type[PhysicsBackend], world: WorldFile, spec: RobotFile) -> Iterator[Make]:
    made: list[PhysicsBackend] = []

    def build(seed: int = 0, robot: RobotFile = spec) -> PhysicsBackend:
        made.append(physics(robot, world, seed))
        return made[-1]

    yield build
    for backend in made:
        backend.close()


class Hand:
    """Arm and gripper of a backend, moved by whole movements."""

    def __init__(self, backend: PhysicsBackend, spec: RobotFile) -> None:
        assert spec.arm is not None
        self.backend = backend
        self.model = ArmModel(spec.urdf_text(), spec.arm.joints)
        capabilities: Any = backend.capabilities()
        _, self.arm, self.gripper, *_ = capabilities

    def go(self, goal: Transform, seconds: float = 2.0) -> None:
        """Move the hand to a pose of `base`, in a straight line of the joints."""
        joints = self.model.inverse(goal, self.arm.command())
        assert joints is not None
        self.joints(joints, seconds)

    def joints(self, end: np.ndarray, seconds: float = 2.0) -> None:
        start = np.array(self.arm.command())
        count = round(seconds / self.backend.period)
        for number in range(1, count + 1):
            self.arm.move(start + (end - start) * number / count)
            self.backend.step()

    def take_book(self) -> None:
        """Grip the book on the tray by its spine."""
        book = self.backend.scene.of(BookProps).tray_book()
        assert book is not None
        spine = book.base_T_thing[:3, 3]
        for x, z in ((-0.10, 0.80), (-0.10, 0.70), (spine[0] - 0.12, 0.70)):
            self.line(x, spine[1], z)
        self.grip(0.0)

    def line(self, x: float, y: float, z: float) -> None:
        """Move the hand straight, upright and pointing forward."""
        start = self.model.forward(self.arm.command())[:3, 3]
        goal = np.array([x, y, z])
        for share in np.linspace(0.0, 1.0, max(2, int(np.linalg.norm(goal - start) / 0.004)) + 1)[1:]:
            joints = self.arm.command()
            near = self.model.inverse(transform(tuple(start + share * (goal - start))), joints, restarts=0)
            assert near is not None
            while not np.allclose(joints, near):
                joints = joints + np.clip(near - joints, -0.07, 0.07)
                self.arm.move(joints)
                self.backend.step()

    def grip(self, width: float, seconds: float = 2.0) -> None:
        self.gripper.move(width)
        for _ in range(round(seconds / self.backend.period)):
            self.backend.step()


@pytest.fixture
def hand(make: Make, spec: RobotFile) -> Hand:
    return Hand(make(), spec)


@pytest.fixture
def hand_of(spec: RobotFile) -> Callable[[PhysicsBackend], Hand]:
    return lambda backend: Hand(backend, spec)
