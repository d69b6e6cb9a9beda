"""LOOK_FOR, PICK, PLACE, STOW and MOVE_ARM at two tables, against the ground truth."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.backends.simulation.objects.pull_spec import PullSpec
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.move_arm import MoveArm
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.objects.stow import Stow
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.transform import transform
from tests.primitives.changed_scene import do_when

from .fetching import at_table_a, changed, rig_with, scene_of


def thing(rig: Rig, name: str = "parcel_1") -> Any:
    return scene_of(rig).thing_named(f"object {name}")


def look_and_pick(rig: Rig, **parameters: Any) -> None:
    for primitive in (LookFor(object="parcel_1"), Pick(object="parcel_1", **parameters)):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome


@pytest.mark.slow
def test_parcel_is_lifted_over_one_like_it() -> None:
    """Another parcel with the same tag may be beside it, out of the picture."""
    rig = at_table_a(seed=3)
    foot, height = float(thing(rig).pose[2, 3]), 0.08
    look_and_pick(rig, stow=False)
    assert float(thing(rig).pose[2, 3]) - foot > height + 0.004


@pytest.mark.slow
def test_object_off_its_believed_place_is_found() -> None:
    rig = at_table_a(seed=3)
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    seen, true = rig.model.of(Objects).seen("parcel_1"), thing(rig).pose
    assert seen is not None
    assert (seen.pose.x, seen.pose.y) == pytest.approx(true[:2, 3], abs=0.012)
    assert seen.pose.theta == pytest.approx(math.atan2(true[1, 0], true[0, 0]), abs=0.01)
    assert 0.001 < math.sqrt(seen.covariance[0][0]) < 0.01


@pytest.mark.slow
def test_object_seen_less_exactly_than_needed_fails() -> None:
    rig = at_table_a(seed=3)
    outcome = rig.do(LookFor(object="parcel_1", tolerance_mm=2.0))
    assert isinstance(outcome, Fail)
    assert outcome.cause.name == "undetermined"
    assert outcome.reason.startswith("parcel_1: the position is not determined")
    assert rig.model.of(Objects).seen("parcel_1") is None


@pytest.mark.slow
def test_missing_object_fails_with_what_was_seen_instead(tmp_path: Path) -> None:
    world = changed(tmp_path, "world.yaml", ("id: 7", "id: 9"))
    rig = at_table_a(world=world)
    outcome = rig.do(LookFor(object="parcel_1", max_views=4))
    assert isinstance(outcome, Fail)
    assert outcome.reason.startswith("parcel_1 isn't seen on table_a; seen: ")
    assert "tag apriltag_36h11 9" in outcome.reason
    assert outcome.cause.name == "not_seen"


@pytest.mark.slow
def test_two_objects_with_one_tag_are_ambiguous(tmp_path: Path) -> None:
    twin = ("x_m: 2.3, y_m: 3.7, height_m: 0.6", "x_m: 2.01, y_m: 3.66, height_m: 0.6")
    world = changed(tmp_path, "world.yaml", ("id: 8", "id: 7"), twin, ("sigma_mm: 40", "sigma_mm: 0"))
    outcome = at_table_a(world=world).do(LookFor(object="parcel_1"))
    assert isinstance(outcome, Fail)
    assert (outcome.cause.name, "two objects have its tag" in outcome.reason) == ("ambiguous", True)


@pytest.mark.slow
def test_fallen_object_is_not_taken_for_an_upright_one() -> None:
    rig = at_table_a()
    fallen = thing(rig)
    fallen.pose = fallen.pose @ transform((0.0, 0.0, 0.03), (math.radians(60.0), 0.0, 0.0))
    outcome = rig.do(LookFor(object="parcel_1"))
    assert isinstance(outcome, Fail)
    assert outcome.cause.name in ("misplaced", "not_seen")


@pytest.mark.slow
def test_object_is_picked_upright_and_known_in_the_hand() -> None:
    rig = at_table_a()
    look_and_pick(rig)
    scene, held = scene_of(rig), rig.model.of(Objects).held_object
    assert held is not None
    assert scene.held is thing(rig)
    assert scene.held.tilt() < math.radians(2.0)
    assert held.hand_T_object == pytest.approx(scene.hand_T_held, abs=2e-3)
    assert rig.model.of(Objects).seen("parcel_1") is None
    assert np.hypot(*(scene.world_T("hand")[:2, 3] - (scene.base.x, scene.base.y))) < 0.34
    assert [contact.other for contact in scene.contacts] == []


@pytest.mark.slow
def test_next_grasp_differs_from_the_best_one() -> None:
    grips = []
    for grasp in ("best", "next"):
        rig = at_table_a()
        look_and_pick(rig, grasp=grasp, stow=False)
        grips.append(scene_of(rig).hand_T_held[:3, :3])
    assert np.abs(grips[0] - grips[1]).max() > 0.4


@pytest.mark.slow
def test_pick_that_fails_after_the_lift_puts_the_object_back() -> None:
    rig = at_table_a()
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    before, joints = thing(rig).pose.copy(), scene_of(rig).joints.copy()
    outcome = do_when(
        rig, Pick(object="parcel_1"), lambda scene: scene.held is not None, lambda _: _break_camera_once(rig)
    )
    assert isinstance(outcome, Fail), outcome
    assert thing(rig).pose[:3, 3] == pytest.approx(before[:3, 3], abs=0.003)
    assert scene_of(rig).joints == pytest.approx(joints, abs=0.01)
    assert rig.model.of(Objects).held_object is None
    assert rig.model.of(Objects).seen("parcel_1") is not None


def _break_camera_once(rig: Rig) -> None:
    """Let the next picture be lost."""
    take = rig.robot.picture

    def lost() -> Any:
        rig.robot.picture = take  # type: ignore[method-assign]
        raise OSError("no picture")

    rig.robot.picture = lost  # type: ignore[method-assign]


@pytest.mark.slow
def test_object_taken_away_before_the_grasp_is_a_fail() -> None:
    rig = at_table_a()
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    thing(rig).pose = transform((1.0, 0.3, 0.0))
    outcome = rig.do(Pick(object="parcel_1"))
    assert isinstance(outcome, Fail)
    assert outcome.cause.name == "not_seen"


@pytest.mark.slow
def test_wrong_weight_is_put_back(tmp_path: Path) -> None:
    world = changed(tmp_path, "world.yaml", ("name: parcel_1", "name: parcel_1\n    mass_kg: 0.9"))
    rig = at_table_a(world=world)
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    outcome = rig.do(Pick(object="parcel_1"))
    assert isinstance(outcome, Fail)
    assert "doesn't weigh as much as parcel_1" in outcome.reason
    assert scene_of(rig).held is None


@pytest.mark.slow
def test_object_with_a_small_tag_is_looked_for_from_nearer(tmp_path: Path) -> None:
    small = ("tags: [{id: 7, side_mm: 40}]", "tags: [{id: 7, side_mm: 7}]")
    rig = at_table_a(changed(tmp_path, "world.yaml", small), changed(tmp_path, "objects.yaml", small))
    outcome = rig.do(LookFor(object="parcel_1"))
    assert isinstance(outcome, Success), outcome


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_object_on_the_other_half_of_a_surface_is_found_there(tmp_path: Path, seed: int) -> None:
    """A wide bin or table is two surfaces side by side, and no scan shows where one ends."""
    whole = "table_a: {x_m: 2.0, y_m: 3.8, height_m: 0.6, size_m: [1.2, 0.6]}"
    left, right = (whole.replace("2.0", x).replace("1.2", "0.6") for x in ("1.7", "2.3"))
    halves = f"{left}\n  {right.replace('table_a', 'table_c')}"
    kept = ("parcel_2: {kind: parcel, on: table_a", "parcel_2: {kind: parcel, on: table_c")
    objects = changed(tmp_path, "objects.yaml", (whole, halves), ("x_m: 1.9,", "x_m: 1.97,"), kept)
    world = changed(tmp_path, "world.yaml", ("x_m: 1.9\n", "x_m: 2.05\n"), ("sigma_mm: 40", "sigma_mm: 0"))
    rig = at_table_a(world, objects, seed)
    outcome = rig.do(LookFor(object="parcel_1"))
    assert isinstance(outcome, Success), outcome
    seen = rig.model.of(Objects).seen("parcel_1")
    assert seen is not None and seen.surface == "table_c"
    outcome = rig.do(Pick(object="parcel_1"))
    assert isinstance(outcome, Success), outcome


@pytest.mark.slow
def test_object_that_slips_needs_a_person() -> None:
    def slip(scene: Any) -> None:
        held, scene.held = scene.held, None
        scene.props_of(held).let_go(held)

    rig = at_table_a()
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    pick = Pick(object="parcel_1")
    outcome = do_when(rig, pick, lambda scene: scene.held is not None and scene.held.pose[2, 3] > 0.63, slip)
    assert isinstance(outcome, GiveUp), outcome


@pytest.mark.slow
def test_pick_without_a_sighting_is_not_begun() -> None:
    outcome = at_table_a().do(Pick(object="parcel_1"))
    assert isinstance(outcome, Fail)
    assert (outcome.cause.name, outcome.reason) == (
        "precondition",
        "parcel_1 wasn't seen yet; LOOK_FOR finds it",
    )


@pytest.mark.slow
@pytest.mark.parametrize("spot", ["left", None])
def test_object_is_put_down_on_the_other_table(spot: str | None) -> None:
    rig = at_table_a()
    look_and_pick(rig)
    for primitive in (MoveTo(place="table_b"), PlaceObject(surface="table_b", spot=spot)):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    pose, seen = thing(rig).pose, rig.model.of(Objects).seen("parcel_1")
    assert seen is not None
    assert (seen.pose.x, seen.pose.y) == pytest.approx(pose[:2, 3], abs=0.012)
    assert (seen.surface, pose[2, 3]) == ("table_b", pytest.approx(0.6))
    if spot is not None:
        assert pose[:2, 3] == pytest.approx((5.05, 2.2), abs=0.012)
        assert math.atan2(pose[1, 0], pose[0, 0]) == pytest.approx(0.0, abs=0.02)


@pytest.mark.slow
def test_occupied_spot_is_seen_and_a_free_one_taken(tmp_path: Path) -> None:
    other = "  - {name: box, x_m: 5.03, y_m: 2.19, height_m: 0.6, size_mm: [80, 60, 40]}\n"
    world = changed(tmp_path, "world.yaml", ("  - {name: parcel_2", other + "  - {name: parcel_2"))
    rig = at_table_a(world=world)
    look_and_pick(rig)
    assert isinstance(rig.do(MoveTo(place="table_b")), Success)
    outcome = rig.do(PlaceObject(surface="table_b", spot="left"))
    assert isinstance(outcome, Fail), outcome
    assert (outcome.cause.name, scene_of(rig).held) == ("occupied", thing(rig))
    outcome = rig.do(PlaceObject(surface="table_b"))
    assert isinstance(outcome, Success), outcome
    away = np.hypot(*(thing(rig).pose[:2, 3] - thing(rig, "box").pose[:2, 3]))
    assert away > 0.09
    assert thing(rig, "box").pose[:2, 3] == pytest.approx((5.03, 2.19), abs=0.002)


@pytest.mark.slow
def test_surface_lower_than_known_leaves_the_object_in_the_hand(tmp_path: Path) -> None:
    world = changed(tmp_path, "world.yaml", ("[0.6, 1.2, 0.6]", "[0.6, 1.2, 0.57]"))
    rig = at_table_a(world=world)
    look_and_pick(rig)
    assert isinstance(rig.do(MoveTo(place="table_b")), Success)
    outcome = rig.do(PlaceObject(surface="table_b", spot="left"))
    assert isinstance(outcome, Fail), outcome
    assert (outcome.cause.name, scene_of(rig).held) == ("no_support", thing(rig))
    assert rig.model.of(Objects).held_object is not None


@pytest.mark.slow
def test_stow_brings_the_load_inside_and_move_arm_names_postures() -> None:
    rig = at_table_a()
    look_and_pick(rig, stow=False)
    assert isinstance(rig.do(Stow()), Success)
    scene = scene_of(rig)
    assert np.hypot(*(scene.held.pose[:2, 3] - (scene.base.x, scene.base.y))) < 0.34
    assert scene.held.tilt() < math.radians(2.0)
    outcome = rig.do(MoveArm(posture="hoem"))
    assert isinstance(outcome, Fail)
    assert "no posture 'hoem'; allowed: home" in outcome.reason


@pytest.mark.slow
def test_tag_on_a_side_faces_the_robot_where_it_is_put(tmp_path: Path) -> None:
    side = ("tags: [{id: 7, side_mm: 40}]", "tags: [{id: 7, side_mm: 40, face: '-y'}]")
    world = changed(tmp_path, "world.yaml", side, ("sigma_deg: 30", "sigma_deg: 10"))
    rig = rig_with(changed(tmp_path, "objects.yaml", side), world)
    assert isinstance(rig.do(MoveTo(place="table_a")), Success)
    look_and_pick(rig, to="table_b")
    for primitive in (MoveTo(place="table_b"), PlaceObject(surface="table_b")):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    normal = thing(rig).pose[:3, :3] @ (0.0, -1.0, 0.0)
    assert normal[0] < -0.5  # the robot is at lower x


def falsify_force(rig: Rig, monkeypatch: pytest.MonkeyPatch, replaced: Callable[[int, Any], Any]) -> None:
    """Replace the readings of the force on the hand, each given with its number from 0."""
    honest, count = rig.robot.arm.hand_force, itertools.count()
    monkeypatch.setattr(rig.robot.arm, "hand_force", lambda: replaced(next(count), honest()))


@pytest.mark.slow
@pytest.mark.parametrize(("silent", "cause"), [(3, None), (10_000, "sensor_fault")])
def test_place_without_a_reading_of_the_force_does_not_press_on(
    monkeypatch: pytest.MonkeyPatch, silent: int, cause: str | None
) -> None:
    """A weight of NaN made each force on the way down harmless."""
    rig = at_table_a(seed=3)
    look_and_pick(rig, stow=False)
    falsify_force(rig, monkeypatch, lambda number, force: np.nan * force if number < silent else force)
    outcome = rig.do(PlaceObject(surface="table_a"))
    if cause is None:
        assert isinstance(outcome, Success), outcome
    else:
        assert not isinstance(outcome, Success)
        assert outcome.cause.name == cause


@pytest.mark.slow
def test_pick_with_a_force_that_stands_still_names_the_sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = at_table_a(seed=3)
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    kept: list[Any] = []

    def frozen(number: int, force: Any) -> Any:
        kept.append(force)
        return kept[-1] if thing(rig).rest.value != "hand" else kept[0]

    falsify_force(rig, monkeypatch, frozen)
    outcome = rig.do(Pick(object="parcel_1"))
    assert not isinstance(outcome, Success)
    assert outcome.cause.name == "sensor_fault", outcome


@pytest.mark.slow
@pytest.mark.parametrize("primitive", [Stow(), MoveArm(posture="home"), MoveTo(place="table_b")])
def test_object_that_is_torn_out_of_the_hand_is_no_success(primitive: ActionPrimitive) -> None:
    rig = at_table_a()
    look_and_pick(rig, stow=isinstance(primitive, MoveTo))
    begun, props = rig.robot.time, scene_of(rig).of(ObjectProps)
    tear = PullSpec(at_s=0.0, force_n=300.0, ramp_s=1.0, duration_s=2.0)
    outcome = do_when(rig, primitive, lambda _: rig.robot.time > begun + 0.3, lambda _: props.pull_now(tear))
    assert scene_of(rig).held is None
    assert isinstance(outcome, GiveUp), outcome
    assert outcome.cause.name == "slipped"
