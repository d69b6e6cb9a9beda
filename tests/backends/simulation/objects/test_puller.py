"""A simulated person pulls at what the hand holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.objects.handing import rig_holding, scene_of, world_with
from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.backends.simulation.objects.pull_spec import PullSpec
from handcart.backends.simulation.world.thing import Rest
from handcart.files.errors import FileError
from handcart.robotics.numerics.arrays import FloatArray


def test_pull_needs_one_beginning() -> None:
    for wrong in ({}, {"at_s": 1.0, "waits_s": 1.0}):
        with pytest.raises(ValueError, match="a pull begins at at_s or after waits_s; allowed: one of them"):
            PullSpec.model_validate(wrong)


def test_wrong_direction_is_named_at_its_line(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="direction"):
        rig_holding(world_with(tmp_path, [{"at_s": 1.0, "direction": "upp"}]))


def test_object_let_go_during_a_pull_stays_with_the_person(tmp_path: Path) -> None:
    with rig_holding(world_with(tmp_path, [])) as rig:
        scene, step = scene_of(rig), rig.robot.step
        props = scene.of(ObjectProps)
        weight = _felt(rig)
        props.pull_now(PullSpec(at_s=0.0, force_n=20.0, direction="up", ramp_s=0.0, duration_s=0.4))
        step()
        assert _felt(rig) - weight == pytest.approx((0.0, 0.0, 20.0), abs=0.2)
        kept = props.pulls, props.held_out
        rig.robot.gripper.move(0.07)
        for _ in range(6):
            step()
        thing = scene.thing_named("object parcel_1")
        assert thing is not None and thing.rest is Rest.PERSON
        assert thing.pose[2, 3] > 2.0
        assert kept[0] == [(kept[0][0].spec, kept[0][0].begun_s, False)]
        assert props.pulls[0].is_over


def test_pull_ends_by_itself_and_what_is_let_go_later_falls(tmp_path: Path) -> None:
    with rig_holding(world_with(tmp_path, [{"at_s": 0.0, "force_n": 10.0, "duration_s": 0.3}])) as rig:
        scene = scene_of(rig)
        for _ in range(12):
            rig.robot.step()
        assert scene.of(ObjectProps).puller.force == pytest.approx(np.zeros(3))
        rig.robot.gripper.move(0.07)
        for _ in range(6):
            rig.robot.step()
        thing = scene.thing_named("object parcel_1")
        assert thing is not None and thing.rest is not Rest.PERSON


def test_hand_within_the_outline_offers_nothing_to_who_waits(tmp_path: Path) -> None:
    with rig_holding(world_with(tmp_path, [{"waits_s": 0.1}])) as rig:
        for _ in range(20):
            rig.robot.step()
        assert scene_of(rig).of(ObjectProps).pulls[0].begun_s is None


def test_pull_beyond_the_friction_of_the_fingers_tears_the_object_out(tmp_path: Path) -> None:
    with rig_holding(world_with(tmp_path, [], friction=0.2)) as rig:
        scene = scene_of(rig)
        limit = 1.5 * 0.2 * 2 * 60.0  # pads, object, two fingers
        for force, held in ((limit - 8.0, True), (limit + 8.0, False)):
            scene.of(ObjectProps).pull_now(PullSpec(at_s=0.0, force_n=force, ramp_s=0.0, duration_s=0.05))
            rig.robot.step()
            assert (scene.held is not None) is held
            rig.robot.step()


def _felt(rig: object) -> FloatArray:
    scene = scene_of(rig)  # type: ignore[arg-type]
    return np.asarray(scene.world_T("hand")[:3, :3] @ scene.felt_force())
