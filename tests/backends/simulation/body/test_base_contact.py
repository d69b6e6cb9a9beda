"""Contacts of a base with a polygonal footprint in the kinematic world."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_names import robot_path
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.body.base_contact import base_gap
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load

WORLD = """
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0, heading_deg: 0}
furniture:
  - {name: post, x_m: 0.9, y_m: 0.3, heading_deg: 0, size_m: [0.2, 0.2, 1.0]}
  - {name: side, x_m: 0.0, y_m: 0.5, heading_deg: 0, size_m: [0.4, 0.3, 1.0]}
"""
Make = Callable[[str], Any]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    def made(footprint: str) -> KinematicBackend:
        text = robot_path("cart").read_text(encoding="utf-8").splitlines()
        lines = [footprint if line.startswith("footprint_radius_m") else line for line in text]
        (tmp_path / "robot.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
        shutil.copy(robot_path("cart").parent / "cart.urdf", tmp_path)
        (tmp_path / "world.yaml").write_text(WORLD, encoding="utf-8")
        world = load(tmp_path / "world.yaml", world_model())
        return KinematicBackend(load_robot(str(tmp_path / "robot.yaml")), world, 0)

    return made


def drive(backend: Any, speed: float, turn_rate: float, periods: int = 60) -> None:
    for _ in range(periods):
        backend.get(Base).drive(speed, turn_rate)
        backend.step()


def test_rectangle_stops_where_its_front_touches(make: Make) -> None:
    backend = make("footprint: {rectangle_m: [0.6, 0.44]}")
    drive(backend, 0.3, 0.0)
    scene = backend.scene
    assert {contact.other for contact in scene.contacts} == {"post"}
    assert scene.base.x == pytest.approx(0.8 - 0.3, abs=0.01)
    assert 0.0 <= base_gap(scene, scene.base)[0] < 0.01


def test_rectangle_passes_what_a_disc_around_it_touches(make: Make) -> None:
    backend = make("footprint: {rectangle_m: [0.6, 0.3]}")
    drive(backend, 0.3, 0.0, 120)
    assert not backend.scene.contacts
    assert backend.scene.base.x > 1.0


def test_turning_rectangle_touches_with_a_corner(make: Make) -> None:
    backend = make("footprint: {rectangle_m: [0.9, 0.44]}")
    drive(backend, 0.0, 0.5)
    assert {contact.other for contact in backend.scene.contacts} == {"side"}
    assert 0.0 < backend.scene.base.theta < math.radians(30)
