"""Blocks, tables and marks in physics."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.saved_state import pack, unpack
from handcart.backends.simulation.blocks.block_props import BlockProps
from handcart.backends.simulation.calibration.mark_props import MarkProps
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load
from handcart.robotics.geometry.transform import inverse, transform
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks
from handcart.robotics.perception.landmarks.landmark_pose import facing, planar_pose

WORLD = """
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0}
tables:
  - {name: table, x_m: 0.08, y_m: 0.65, size_m: [0.66, 0.76, 0.4], foot_m: [0.3, 0.2]}
marks:
  - {x_m: 0.0, y_m: 0.5, height_m: 0.4}
blocks:
"""
ON_TRAY = '  - {name: "1", on: robot, x_m: -0.26, y_m: 0.0, height_m: 0.45}\n'
PILE = "".join(
    f'  - {{name: "{n}", x_m: 0.15, y_m: 0.45, height_m: {0.32 + 0.04 * n:.2f}}}\n' for n in (2, 3, 4)
)
SHIFTED = '  - {name: "5", x_m: 0.168, y_m: 0.45, height_m: 0.52}\n'
OVER = 0.165  # [m] from the foot of a block that is gripped up to the hand

Build = Callable[..., PhysicsBackend]


@pytest.fixture
def build(physics: type[PhysicsBackend], tmp_path: Path) -> Iterator[Build]:
    """Makes a robot that doesn't err at the table, with these blocks."""
    made: list[PhysicsBackend] = []

    def make(blocks: str, robot: RobotFile | None = None) -> PhysicsBackend:
        path = tmp_path / "world.yaml"
        path.write_text(WORLD + blocks, encoding="utf-8")
        robot = load_robot("toyama").without_errors() if robot is None else robot
        made.append(physics(robot, load(path, world_model()), 0))
        return made[-1]

    yield make
    for backend in made:
        backend.close()


def part(backend: PhysicsBackend, name: str) -> Any:
    return next(
        capability for capability in backend.capabilities() if type(capability).__name__.endswith(name)
    )


def steps(backend: PhysicsBackend, count: int) -> None:
    for _ in range(count):
        backend.step()


def go(backend: PhysicsBackend, x: float, y: float, z: float, speed: float = 0.1) -> None:
    """Move the hand straight, pointing down, its fingers closing along x."""
    arm, model = part(backend, "Arm"), backend.scene.arm
    assert model is not None
    turn = transform(rpy=(0.0, np.pi / 2, 0.0)) @ transform(rpy=(-np.pi / 2, 0.0, 0.0))
    start, goal = model.forward(arm.command())[:3, 3], np.array([x, y, z])
    count = max(2, int(np.linalg.norm(goal - start) / speed / backend.period))
    for share in np.linspace(0.0, 1.0, count + 1)[1:]:
        joints = arm.command()
        near = model.inverse(transform(tuple(start + share * (goal - start))) @ turn, joints)
        assert near is not None
        while not np.allclose(joints, near):
            joints = joints + np.clip(near - joints, -0.09, 0.09)
            arm.move(joints)
            backend.step()
    steps(backend, 5)


def grip(backend: PhysicsBackend, width: float) -> None:
    part(backend, "Gripper").move(width)
    steps(backend, 24)


def turn_of(block: Thing) -> float:
    return float(np.arctan2(block.pose[1, 0], block.pose[0, 0]))


def test_blocks_stand_on_tables_on_each_other_and_on_the_robot(build: Build) -> None:
    backend = build(ON_TRAY + PILE)
    steps(backend, 40)
    blocks = backend.scene.of(BlockProps).blocks
    assert blocks["1"].rest is Rest.TRAY
    assert np.abs(blocks["1"].base_T_thing[:3, 3] - (-0.26, 0.0, 0.45)).max() < 2e-4
    for number in (2, 3, 4):
        block = blocks[str(number)]
        assert block.rest is Rest.TABLE
        assert np.abs(block.pose[:3, 3] - (0.15, 0.45, 0.32 + 0.04 * number)).max() < 2e-4
    assert backend.scene.contacts == []


def test_a_block_whose_middle_nothing_carries_falls_and_is_lost(build: Build) -> None:
    backend = build(PILE + SHIFTED)
    steps(backend, 40)
    assert backend.scene.of(BlockProps).blocks["5"].rest is Rest.FLOOR
    assert backend.scene.of(BlockProps).blocks["5"].pose[2, 3] < 0.45


@pytest.mark.slow
def test_block_is_picked_carried_and_stacked_without_moving_others(build: Build) -> None:
    backend = build(ON_TRAY + PILE)
    blocks = backend.scene.of(BlockProps).blocks
    before = {name: block.pose.copy() for name, block in blocks.items()}
    go(backend, -0.26, 0.0, 0.45 + OVER)
    grip(backend, 0.0)
    assert backend.scene.held is blocks["1"]
    assert blocks["1"].rest is Rest.HAND
    go(backend, -0.26, 0.0, 0.75, 0.2)
    go(backend, 0.15, 0.45, 0.75, 0.3)
    go(backend, 0.15, 0.45, 0.52 + OVER + 0.01)
    while np.linalg.norm(part(backend, "Arm").hand_force()) < 4.0:
        assert backend.scene.arm is not None
        hand = backend.scene.arm.forward(part(backend, "Arm").command())[:3, 3]
        go(backend, 0.15, 0.45, hand[2] - 0.001)
    there = blocks["1"].pose.copy()
    grip(backend, 0.045)
    assert backend.scene.held is None
    assert blocks["1"].rest is Rest.TABLE
    go(backend, 0.15, 0.45, 0.75)
    assert np.abs(blocks["1"].pose[:2, 3] - there[:2, 3]).max() < 4e-4
    assert blocks["1"].pose[2, 3] == pytest.approx(0.52, abs=3e-4)
    for name in ("2", "3", "4"):
        assert np.abs(blocks[name].pose - before[name])[:2, 3].max() < 2e-4
        assert abs(turn_of(blocks[name])) < 3e-3


def test_fingers_that_press_let_go_at_once(build: Build) -> None:
    backend = build(ON_TRAY)
    go(backend, -0.26, 0.0, 0.45 + OVER)
    grip(backend, 0.0)
    assert backend.scene.held is not None
    part(backend, "Gripper").move(0.045)
    steps(backend, 3)
    assert backend.scene.held is None


@pytest.mark.slow
@pytest.mark.parametrize("drawn_by", ["scene", "engine"])
def test_the_camera_sees_a_mark_where_it_is(build: Build, drawn_by: str) -> None:
    backend = build(f"{ON_TRAY}camera: {drawn_by}\n")
    go(backend, 0.08, 0.5, 0.73)
    camera = part(backend, "Camera")
    world_T_camera = backend.scene.world_T("hand") @ camera.hand_T_camera
    true = inverse(world_T_camera) @ backend.scene.of(MarkProps).marks[0].pose
    (seen,) = find_landmarks(camera.image(), camera.model, 0.06, (0.2, 0.4))
    plane = facing(float(true[2, 3]))
    assert np.abs((plane @ planar_pose(seen, plane).lift() - true)[:2, 3]).max() < 3e-4


@pytest.mark.slow
def test_a_world_put_back_has_its_blocks(build: Build) -> None:
    backend = build(ON_TRAY + PILE)
    go(backend, -0.26, 0.0, 0.45 + OVER)
    grip(backend, 0.0)
    kept = pack(backend.state())
    again = build(ON_TRAY + PILE)
    again.set_state(unpack(kept))
    steps(again, 3)
    assert again.scene.held is again.scene.of(BlockProps).blocks["1"]
    for name, block in backend.scene.of(BlockProps).blocks.items():
        assert np.abs(again.scene.of(BlockProps).blocks[name].pose - block.pose).max() < 1e-4
