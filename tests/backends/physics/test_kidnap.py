"""A robot that is picked up and set down elsewhere: what it carries comes along, and it stands there."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import CAR_WHEELS_M, PhysicsBackend
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.thing import Rest
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load

from .conftest import WORLD, Hand

AT_S = 16.0


@pytest.fixture
def world(tmp_path: Path) -> WorldFile:
    path = tmp_path / "world.yaml"
    there = "{x_m: 2.3, y_m: 1.4, heading_deg: 60}"
    path.write_text(f"{WORLD}kidnap: {{at_s: {AT_S}, to: {there}}}\n", encoding="utf-8")
    return load(path, world_model())


def wait_for_it(backend: PhysicsBackend) -> None:
    while backend.scene.time <= AT_S + 1.0:
        backend.step()


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True])
def test_a_kidnapped_robot_takes_along_what_it_carries(
    physics: type[PhysicsBackend],
    world: WorldFile,
    spec: RobotFile,
    hand_of: Callable[[PhysicsBackend], Hand],
    held: bool,
) -> None:
    backend = physics(robot=spec, world=world, seed=0)
    try:
        hand = hand_of(backend)
        book = backend.scene.of(BookProps).tray_book()
        assert book is not None
        if held:
            hand.take_book()
            here = hand.model.forward(hand.arm.command())[:3, 3]
            hand.line(here[0], here[1], here[2] + 0.08)
        before = np.linalg.inv(backend.link_pose("hand")) @ backend._world.pose(book)
        assert backend.scene.time < AT_S - 0.5
        wait_for_it(backend)
        assert math.hypot(backend.scene.base.x - 2.3, backend.scene.base.y - 1.4) < 0.02
        assert book.rest is (Rest.HAND if held else Rest.TRAY)
        after = np.linalg.inv(backend.link_pose("hand")) @ backend._world.pose(book)
        assert float(np.linalg.norm((after - before)[:3, 3])) < 0.01
    finally:
        backend.close()


@pytest.mark.slow
def test_a_kidnapped_car_is_set_down_on_the_rough_ground_there(
    physics: type[PhysicsBackend], tmp_path: Path
) -> None:
    path = tmp_path / "world.yaml"
    path.write_text(
        "format: handcart-world/1\nstart: {x_m: 0.0, y_m: 0.0}\n"
        "ground: {roughness_deg: 8.0, roughness_length_m: 0.8}\n"
        "kidnap: {at_s: 1.0, to: {x_m: 15.0, y_m: 4.0}}\n",
        encoding="utf-8",
    )
    backend = physics(load_robot("el_verde"), load(path, world_model()), 3)
    try:
        while backend.scene.time < 1.0 - 0.5 * backend.period:
            backend.step()
        backend.step()
        assert abs(backend.scene.base.x - 15.0) < 0.1
        assert backend._terrain is not None
        under = backend._terrain.height(*backend.scene.base.apply(CAR_WHEELS_M).T)
        assert -0.01 < float(backend._body.standing_pose()[2, 3] - under.max()) < 0.05
        while backend.scene.time < 2.0:
            backend.step()
        assert float(backend._body.standing_pose()[2, 2]) > 0.9
    finally:
        backend.close()
