"""HAND_OVER to a simulated person, against the ground truth."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from benchmarks.objects.handing import rig_holding, scene_of, world_with
from handcart.backends.simulation.world.thing import Rest
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.objects.hand_over import HandOver
from handcart.primitives.objects.holding.offering import offering_joints
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.stow import Stow
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success

from .fetching import TASK, changed

PULL = {"waits_s": 1.0, "force_n": 15.0, "sigma_n": 3.0, "sigma_deg": 15.0, "tremor_n": 1.0}


def holding(folder: Path, *pulls: Mapping[str, Any], seed: int = 3, backend: str = "kinematic") -> Rig:
    return rig_holding(world_with(folder, pulls), seed=seed, backend=backend)


def facing_a_wall(folder: Path, *pulls: Mapping[str, Any], x_m: float = 0.62) -> Rig:
    """Return a robot before a mapped wall; by default 0.27 m, nearer than it would hold the object out."""
    return standing_at(folder, f"x_m: {x_m}, y_m: 1.5, heading_deg: 180.0", *pulls)


def standing_at(folder: Path, pose: str, *pulls: Mapping[str, Any]) -> Rig:
    """Return a robot at a pose of the room, given as in a file of places."""
    home = ("x_m: 1.0, y_m: 1.0, heading_deg: 0.0", pose)
    places, world = changed(folder, "places.yaml", home), changed(folder, "world.yaml", home)
    data = yaml.safe_load(world.read_text(encoding="utf-8"))
    world.write_text(yaml.safe_dump({**data, "pulls": [dict(pull) for pull in pulls]}), encoding="utf-8")
    return rig_holding(world, seed=3, places=places)


def in_a_closet(folder: Path) -> Rig:
    """Return a robot between four mapped walls, 0.38 m from its middle, 40 mm from its outline."""
    inner, outer = 0.38, 0.44
    picture = cv2.imread(str(TASK / "map.png"), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    y, x = np.indices(picture.shape)
    off = np.maximum(abs(0.02 * x - 0.26 - 1.0), abs(0.02 * (len(picture) - 1 - y) - 0.26 - 1.0))
    picture[(off > inner) & (off < outer)] = 0
    cv2.imwrite(str(folder / "map.png"), picture)
    known_map, world = changed(folder, "map.yaml"), changed(folder, "world.yaml")
    places = changed(folder, "places.yaml")
    places.write_text(
        places.read_text(encoding="utf-8") + "  hall: {x_m: 3.0, y_m: 2.0, heading_deg: 0.0}\n",
        encoding="utf-8",
    )
    data = yaml.safe_load(world.read_text(encoding="utf-8"))
    away, corners = (inner + outer) / 2, [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
    ends = [[1.0 + away * u, 1.0 + away * v] for u, v in corners]
    data["walls"] += [{"from_m": list(a), "to_m": list(b), "thickness_m": 0.06} for a, b in pairwise(ends)]
    world.write_text(yaml.safe_dump(data), encoding="utf-8")
    return rig_holding(world, seed=3, places=places, known_map=known_map)


def rest_of(rig: Rig) -> Rest:
    thing = scene_of(rig).thing_named("object parcel_1")
    assert thing is not None
    return thing.rest


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco"])
def test_person_who_pulls_has_the_object(tmp_path: Path, backend: str) -> None:
    with holding(tmp_path, PULL, backend=backend) as rig:
        primitive = HandOver()
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
        assert rest_of(rig) is Rest.PERSON
        assert rig.model.of(Objects).held_object is None
        assert primitive.facts["floor"] == "free"
        assert primitive.facts["pull"] == "ahead"
        assert scene_of(rig).joints == pytest.approx(np.array(rig.robot.spec.posture("home")), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("pulls", [(), ({**PULL, "force_n": 40.0, "ramp_s": 0.0, "duration_s": 0.15},)])
def test_nobody_pulls_and_the_object_stays_in_the_hand(tmp_path: Path, pulls: Any) -> None:
    with holding(tmp_path, *pulls) as rig:
        before = scene_of(rig).joints.copy()
        outcome = rig.do(HandOver(wait_s=3.0))
        assert isinstance(outcome, Fail), outcome
        assert outcome.cause.name == "not_taken"
        assert rest_of(rig) is Rest.HAND
        assert scene_of(rig).joints == pytest.approx(before, abs=0.005)
        assert rig.model.of(Objects).held_object is not None


@pytest.mark.slow
def test_object_is_not_held_out_into_a_mapped_wall(tmp_path: Path) -> None:
    with facing_a_wall(tmp_path) as rig:
        outcome = rig.do(HandOver(wait_s=1.0))
        assert isinstance(outcome, Fail) and outcome.cause.name == "not_taken", outcome
        assert rest_of(rig) is Rest.HAND


@pytest.mark.slow
@pytest.mark.parametrize("posture", [None, "out"])
def test_object_that_walls_leave_no_room_for_stays_in_the_hand(tmp_path: Path, posture: str | None) -> None:
    with in_a_closet(tmp_path) as rig:
        objects, arm = rig.model.of(Objects), rig.robot.spec.arm
        assert objects.held_object is not None and arm is not None
        kind, grip = objects.objects.kind_of("parcel_1"), objects.held_object.hand_T_object
        out = offering_joints(rig.robot, kind, grip, 1.0)
        assert out is not None
        arm.postures["out"] = tuple(np.degrees(out).tolist())
        outcome = rig.do(HandOver(posture=posture))
        assert isinstance(outcome, Fail), outcome
        assert outcome.cause.name == "out_of_reach", outcome
        assert rest_of(rig) is Rest.HAND
        assert not scene_of(rig).contacts


@pytest.mark.slow
def test_object_is_handed_over_beside_a_mapped_wall(tmp_path: Path) -> None:
    """The edges of the wall in the picture of the floor are no fallen object."""
    with facing_a_wall(tmp_path, PULL) as rig:
        primitive = HandOver()
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
        assert rest_of(rig) is Rest.PERSON
        assert primitive.facts["floor"] == "not seen"


@pytest.mark.slow
def test_object_handed_over_is_no_longer_at_its_old_place(tmp_path: Path) -> None:
    """The hand is where the file states the object; on the way home it has nothing to touch there."""
    with standing_at(tmp_path, "x_m: 1.9, y_m: 3.0, heading_deg: 90.0", PULL) as rig:
        outcome = rig.do(HandOver(height_mm=700.0))
        assert isinstance(outcome, Success), outcome
        assert rig.model.of(Objects).handed_over == ("parcel_1",)


@pytest.mark.slow
def test_arm_that_an_unknown_obstacle_stops_goes_back(tmp_path: Path) -> None:
    """A pressing arm is not at rest until it yields; then it retraces only the way that it came."""
    world = world_with(tmp_path, [PULL])
    data = yaml.safe_load(world.read_text(encoding="utf-8"))
    post = {"name": "post", "x_m": 1.62, "y_m": 1.0, "size_m": [0.1, 1.0, 1.8]}
    world.write_text(yaml.safe_dump({**data, "furniture": [*data["furniture"], post]}), encoding="utf-8")
    with rig_holding(world, seed=3) as rig:
        before = scene_of(rig).joints.copy()
        outcome = rig.do(HandOver())
        assert isinstance(outcome, Fail), outcome
        assert rest_of(rig) is Rest.HAND
        assert scene_of(rig).joints == pytest.approx(before, abs=0.005)


@pytest.mark.slow
def test_object_is_stowed_clear_of_a_mapped_wall(tmp_path: Path) -> None:
    with standing_at(tmp_path, "x_m: 1.5, y_m: 0.34, heading_deg: 180.0") as rig:
        outcome = rig.do(Stow())
        assert isinstance(outcome, Success), outcome
        assert not scene_of(rig).contacts


@pytest.mark.slow
def test_object_that_nobody_keeps_is_seen_on_the_floor(tmp_path: Path) -> None:
    with holding(tmp_path, {**PULL, "takes": False}) as rig:
        outcome = rig.do(HandOver())
        assert isinstance(outcome, GiveUp)
        assert (outcome.cause.name, rest_of(rig)) == ("slipped", Rest.FLOOR)


@pytest.mark.slow
def test_thing_almost_as_grey_as_the_floor_is_seen_on_it(tmp_path: Path) -> None:
    world = world_with(tmp_path, [PULL])
    data = yaml.safe_load(world.read_text(encoding="utf-8"))
    box = {"name": "box", "x_m": 1.62, "y_m": 1.05, "size_m": [0.15, 0.15, 0.08]}
    world.write_text(yaml.safe_dump({**data, "surprises": [box]}), encoding="utf-8")
    with rig_holding(world, seed=3) as rig:
        outcome = rig.do(HandOver())
        assert isinstance(outcome, GiveUp)
        assert outcome.reason == "something lies below the hand; parcel_1 may have fallen"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pull", "cause", "rest"),
    [
        ({"at_s": 2.0, "force_n": 20.0, "duration_s": 30.0}, "pulled", Rest.HAND),
        ({"at_s": 2.0, "force_n": 300.0}, "slipped", Rest.PERSON),
    ],
)
def test_pull_on_the_way_calls_a_person(tmp_path: Path, pull: Any, cause: str, rest: Rest) -> None:
    with holding(tmp_path, pull) as rig:
        outcome = rig.do(HandOver())
        assert isinstance(outcome, GiveUp)
        assert (outcome.cause.name, rest_of(rig)) == (cause, rest)


def test_hand_without_force_reading_is_refused_before_it_moves(tmp_path: Path) -> None:
    with holding(tmp_path) as rig:
        rig.robot.arm.hand_force = lambda: np.zeros(3)  # type: ignore[method-assign]
        outcome = rig.do(HandOver())
        assert isinstance(outcome, Fail)
        assert outcome.reason.startswith("nothing measures the force on the hand")


def test_unknown_posture_is_refused_with_the_nearest_name(tmp_path: Path) -> None:
    with holding(tmp_path) as rig:
        outcome = rig.do(HandOver(posture="hom"))
        assert isinstance(outcome, Fail)
        assert "no posture 'hom'; did you mean 'home'?" in outcome.reason


def test_posture_within_the_outline_offers_nothing(tmp_path: Path) -> None:
    with holding(tmp_path) as rig:
        outcome = rig.do(HandOver(posture="home"))
        assert isinstance(outcome, Fail)
        assert outcome.cause.name == "unsuitable"
