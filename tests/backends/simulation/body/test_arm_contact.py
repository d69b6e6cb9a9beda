"""Contacts of the arm with things that may move from period to period."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.body.arm_contact import ArmContact
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.thing import Rest
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from tests.shelf_text import GAP, shelf_text

WORLD = f"""
format: handcart-world/1
start: {{x_m: 2.0, y_m: 1.64, heading_deg: 90}}
furniture: [{{name: lamp, x_m: 0.6, y_m: 1.0, size_m: [0.3, 0.3, 0.3], above_m: 0.8}}]
{shelf_text([101, 102, GAP, 104])}"""


@pytest.fixture
def scene(tmp_path: Path) -> Iterator[Any]:
    (tmp_path / "world.yaml").write_text(WORLD, encoding="utf-8")
    robot = load_robot("librarian")
    with KinematicBackend(robot, load(tmp_path / "world.yaml", world_model()), 0) as backend:
        yield backend.scene


def test_a_thing_is_touched_where_it_stands_now(scene: Any) -> None:
    """Also if it is the only one that has moved since the last look."""
    contact, joints = ArmContact(scene, scene.arm), scene.joints
    hand = (scene.world_T_base @ scene.arm.forward(joints))[:3, 3]
    book = scene.of(BookProps).tray_book()
    book.rest = Rest.TABLE
    found = []
    for ahead in (3.0, 0.0, 3.5, 0.0, 3.0):
        book.pose = transform(tuple(hand - [0.075, ahead, 0.1]))
        scene.changes += 1
        touch = contact.deepest_of_arm(joints)
        found.append(touch.other if touch.depth > 0.0 else "")
    assert found == ["", book.name, "", book.name, ""]


def test_a_thing_that_is_taken_away_is_touched_no_more(scene: Any) -> None:
    contact, joints = ArmContact(scene, scene.arm), scene.joints
    hand = (scene.world_T_base @ scene.arm.forward(joints))[:3, 3]
    book = scene.of(BookProps).tray_book()
    book.rest, book.pose = Rest.TABLE, transform(tuple(hand - [0.075, 0.0, 0.1]))
    scene.changes += 1
    assert contact.deepest_of_arm(joints).depth > 0.0
    book.rest = Rest.FLOOR
    scene.changes += 1
    assert contact.deepest_of_arm(joints).depth == 0.0


@pytest.mark.parametrize(("ahead", "is_touched"), [(0.0, True), (3.0, False)])
def test_driven_arm_touches_a_thing_far_from_walls(scene: Any, ahead: float, is_touched: bool) -> None:
    contact, joints, base = ArmContact(scene, scene.arm), scene.joints, Pose2(40.0, 40.0, 0.0)
    hand = (base.lift() @ scene.arm.forward(joints))[:3, 3]
    book = scene.of(BookProps).tray_book()
    book.rest, book.pose = Rest.TABLE, transform(tuple(hand - [0.075, ahead, 0.1]))
    scene.changes += 1
    assert scene.full_plan.clearance(base.x, base.y, scene.time)[0] > 3.0
    touch = contact.deepest_of_robot(base, joints)
    assert touch.other == (book.name if is_touched else "")


def test_an_arm_in_an_empty_world_touches_nothing(tmp_path: Path) -> None:
    text = "format: handcart-world/1\nstart: {x_m: 0, y_m: 0, heading_deg: 0}\n"
    (tmp_path / "world.yaml").write_text(text, encoding="utf-8")
    with KinematicBackend(
        load_robot("librarian"), load(tmp_path / "world.yaml", world_model()), 0
    ) as backend:
        scene: Any = backend.scene
        assert ArmContact(scene, scene.arm).deepest_of_arm(np.array(scene.joints)).depth == 0.0
