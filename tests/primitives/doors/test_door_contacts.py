"""Contacts of the base with doors, in a world without physics."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.simulation.body.base_contact import base_gap, move_base
from handcart.backends.simulation.world.scene import Scene
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.doors.open_door import OpenDoor
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2

from .door_rig import opening, props, rig_at

LOW = (("height_m: 0.85", "height_m: 0.3"),)  # in front of the body of the base


def scene_of(rig: Rig) -> Scene:
    scene = rig.backend.scene  # type: ignore[attr-defined]
    assert isinstance(scene, Scene)
    return scene


@pytest.mark.parametrize(("world", "stops"), [(LOW, True), ((), False)])
def test_base_stops_at_an_open_drawer_of_its_height(
    tmp_path: Path, world: tuple[tuple[str, str], ...], stops: bool
) -> None:
    with rig_at("drawer", tmp_path, world=world) as rig:
        props(rig).put("drawer", 0.3)
        scene = scene_of(rig)
        before = scene.base
        touches = move_base(scene, Pose2(0.3, 0.0, 0.0), None)
        assert touches == (frozenset({("base", "handle drawer")}) if stops else frozenset())
        assert (scene.base.x - before.x < 0.29) is stops


def test_front_that_moves_into_the_base_stops_and_is_reported(tmp_path: Path) -> None:
    with rig_at("drawer", tmp_path, world=LOW) as rig:
        scene, doors = scene_of(rig), props(rig)
        handle = next(part for part in doors.things() if part.is_handle and part.spec.name == "drawer")
        gap, _ = base_gap(scene, scene.base)
        scene.move_base(scene.base.compose(Pose2(gap - 0.05, 0.0, 0.0)))
        rule = doors.hand_rule(scene.arm)
        scene.held = handle
        rule.gripped(handle)
        pulled = handle.pose[:3, 3] - (0.2, 0.0, 0.0)
        assert rule._follow(handle, pulled) == {("base", "handle drawer")}
        assert opening(rig, "drawer") == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("door", ["drawer", "cupboard"])
def test_shipped_doors_are_opened_without_touching_the_base(tmp_path: Path, door: str) -> None:
    with rig_at(door, tmp_path) as rig:
        outcome = rig.do(OpenDoor(door=door, angle_deg=20.0))
        assert isinstance(outcome, Success), outcome
        assert not [contact for contact in scene_of(rig).contacts if contact.body == "base"]
