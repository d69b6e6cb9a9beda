"""Learned poses of objects survive a checkpoint."""

from __future__ import annotations

import json

import numpy as np
import orjson

from handcart.primitives.objects.knowledge.objects import HeldObject, Objects, ObjectSighting
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform

from ..fetching import rig_with

COVARIANCE = ((4e-6, 1e-7, 0.0), (1e-7, 4e-6, 0.0), (0.0, 0.0, 1e-5))


def test_sightings_and_held_object_survive_a_checkpoint() -> None:
    model, other = rig_with().model, rig_with().model
    objects = model.of(Objects)
    objects.sightings = (ObjectSighting("parcel_2", "table_a", Pose2(2.3, 3.7, 1.2), COVARIANCE),)
    objects.held_object = HeldObject("parcel_1", transform((0.1, 0.0, 0.0), (0.0, 1.5, 0.0)))
    objects.handed_over = ("parcel_2",)
    other.set_state(model.state())
    again = other.of(Objects)
    assert again.handed_over == ("parcel_2",)
    assert again.sightings == objects.sightings
    assert again.held_object is not None
    assert again.held_object.object == "parcel_1"
    assert np.array_equal(again.held_object.hand_T_object, objects.held_object.hand_T_object)
    assert other.places == model.places


def test_checkpoint_from_before_hand_overs_were_noted_is_read() -> None:
    model, other = rig_with().model, rig_with().model
    model.of(Objects).sightings = (ObjectSighting("parcel_2", "table_a", Pose2(2.3, 3.7, 1.2), COVARIANCE),)
    state = model.state()
    del state["sections"]["objects"]["handed_over"]
    other.set_state(state)
    assert other.of(Objects).sightings == model.of(Objects).sightings
    assert other.of(Objects).handed_over == ()


def test_changes_are_written_as_json() -> None:
    model = rig_with().model
    model.of(Objects).held_object = HeldObject("parcel_1", transform())
    changes = model.taken_changes()
    assert json.loads(orjson.dumps(changes))["held_object"][0] == "parcel_1"
    assert model.taken_changes() == {}
