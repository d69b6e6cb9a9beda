"""The survey of objects contradicts false claims, and only those."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.evaluation.conformance.kit import KitSetting
from handcart.evaluation.judging.survey import Claim, SurveyedRun
from handcart.evaluation.objects.object_effects import OBJECT_EFFECTS
from handcart.evaluation.objects.object_mutants import OBJECT_MUTANTS
from handcart.evaluation.objects.object_survey import ObjectSurvey
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.objects.hand_over import HandOver
from handcart.primitives.objects.knowledge.objects import HeldObject, Objects, ObjectSighting
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.move_arm import MoveArm
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from tests.primitives.objects.fetching import rig_with, scene_of

COVARIANCE = ((4e-6, 0.0, 0.0), (0.0, 4e-6, 0.0), (0.0, 0.0, 1e-5))


def survey_of(rig: Rig) -> ObjectSurvey:
    does = frozenset({"LOOK_FOR", "PICK", "PLACE"})
    return ObjectSurvey(SurveyedRun(rig.robot, rig.robot.spec, rig.model, scene_of(rig), does=does))


def wrong_in(rig: Rig, primitive: ActionPrimitive) -> list[str]:
    truth = scene_of(rig).truth()
    return OBJECT_EFFECTS[primitive.label()](survey_of(rig), Claim(primitive, truth, truth))


def note_seen(rig: Rig, x: float, y: float, heading: float, surface: str = "table_a") -> None:
    pose = Pose2(x, y, heading)
    rig.model.of(Objects).sightings = (ObjectSighting("parcel_1", surface, pose, COVARIANCE),)


@pytest.mark.parametrize(
    ("off", "turn", "count"),
    [(0.0, 0.0, 0), (0.010, 0.0, 0), (0.016, 0.0, 1), (0.0, 0.03, 1), (0.05, 0.5, 2)],
)
def test_sighting_is_held_against_its_own_claim(off: float, turn: float, count: int) -> None:
    rig = rig_with()
    thing = scene_of(rig).thing_named("object parcel_1")
    thing.pose = transform((1.9, 3.65, 0.6), (0.0, 0.0, 0.3))
    note_seen(rig, 1.9 + off, 3.65, 0.3 + turn)
    assert len(wrong_in(rig, LookFor(object="parcel_1"))) == count


def test_large_claimed_uncertainty_does_not_excuse_a_large_error() -> None:
    rig = rig_with()
    scene_of(rig).thing_named("object parcel_1").pose = transform((1.9, 3.65, 0.6))
    unsure = tuple(tuple(1e4 * value for value in row) for row in COVARIANCE)
    seen = ObjectSighting("parcel_1", "table_a", Pose2(1.94, 3.65, 0.0), unsure)
    rig.model.of(Objects).sightings = (seen,)
    assert wrong_in(rig, LookFor(object="parcel_1")) == [
        "it is 40.0 mm from where it was seen (at most 25.0)"
    ]
    assert wrong_in(rig, LookFor(object="parcel_1", tolerance_mm=45.0)) == []


def test_wrong_object_in_the_hand_is_false() -> None:
    rig = rig_with()
    scene = scene_of(rig)
    scene.held = scene.thing_named("object parcel_2")
    assert wrong_in(rig, Pick(object="parcel_1")) == ["the hand holds object parcel_2, not object parcel_1"]
    scene.held = scene.thing_named("object parcel_1")
    assert wrong_in(rig, Pick(object="parcel_1")) == []


@pytest.mark.parametrize(
    ("x", "y", "height", "tilt", "words"),
    [
        (5.05, 2.2, 0.6, 0.0, ""),
        (5.05, 2.25, 0.6, 0.0, "from its spot"),
        (4.85, 2.2, 0.6, 0.0, "doesn't stand on table_b"),
        (5.05, 2.2, 0.68, 0.0, "off the surface"),
        (5.05, 2.2, 0.6, 0.4, "tilted"),
    ],
)
def test_placed_object_has_to_stand_at_its_spot(
    x: float, y: float, height: float, tilt: float, words: str
) -> None:
    rig = rig_with()
    scene_of(rig).thing_named("object parcel_1").pose = transform((x, y, height), (tilt, 0.0, 0.0))
    note_seen(rig, x, y, 0.0, "table_b")
    primitive = PlaceObject(surface="table_b", spot="left")
    primitive._before = HeldObject("parcel_1", transform())
    wrong = wrong_in(rig, primitive)
    assert any(words in text for text in wrong) if words else wrong == []


@pytest.mark.parametrize("rest", ["person", "hand", "floor", "table"])
def test_object_handed_over_has_to_be_with_a_person(rest: str) -> None:
    rig = rig_with()
    thing = scene_of(rig).thing_named("object parcel_1")
    thing.rest = type(thing.rest)(rest)
    primitive = HandOver()
    primitive._before = HeldObject("parcel_1", transform())
    wrong = [] if rest == "person" else [f"no person has parcel_1, the {rest} has it"]
    assert wrong_in(rig, primitive) == wrong


def test_object_on_the_floor_contradicts_the_run() -> None:
    rig = rig_with()
    survey, thing = survey_of(rig), scene_of(rig).thing_named("object parcel_2")
    assert survey.faults() == []
    thing.rest = type(thing.rest).FLOOR
    assert survey.faults() == ["object parcel_2 has fallen"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["DropsParcel", "TurnsSighting", "PlacesBlindly", "LetsGoUnasked"])
def test_faulty_primitive_is_found(name: str) -> None:
    mutant = next(object_mutant for object_mutant in OBJECT_MUTANTS if object_mutant.name == name)
    assert mutant.look(KitSetting("kinematic", "librarian").bench) != []


@pytest.mark.parametrize(("off_deg", "count"), [(0.0, 0), (0.5, 0), (1.5, 1)])
def test_an_arm_is_held_against_its_posture(off_deg: float, count: int) -> None:
    rig = rig_with()
    joints = np.array(rig.robot.spec.posture("home"))
    joints[2] += np.radians(off_deg)
    scene_of(rig).joints = joints
    assert len(wrong_in(rig, MoveArm(posture="home"))) == count
