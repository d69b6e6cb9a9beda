"""Surroundings of a recorded run as scene entities."""

from __future__ import annotations

import io
import math
from types import SimpleNamespace
from typing import Any, cast

import foxglove
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from handcart.evaluation.viewing.export.scene import on_map, scene_messages, unique_ids
from handcart.evaluation.viewing.export.stamped import nanoseconds
from handcart.evaluation.viewing.playback.playback import Playback, ThingTrack
from handcart.evaluation.viewing.playback.scenery import SolidShape, ThingShape

HERE = (1.0, 3.0, 0.5, 1.0, 0.0, 0.0, 0.0)
NO_TURN = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def recorded(world_t_map: tuple[float, float, float], *names: str) -> Playback:
    """Return a recording of solids with these names, and of a thing, all at one place in the world."""
    solids = [SolidShape(name=name, pose=HERE, size_m=(1.0, 1.0, 1.0), leaves_s=1.0) for name in names]
    tin = ThingShape(name="tin", size_m=(0.1, 0.1, 0.1), middle=NO_TURN, grey=9)
    return cast(
        "Playback",
        SimpleNamespace(
            rows=SimpleNamespace(time=np.array([0.0, 2.0]), world_time=np.array([0.0, 2.0])),
            scenery=SimpleNamespace(solids=solids, world_t_map=world_t_map),
            things={"tin": ThingTrack(tin, np.array([0.0]), np.array([HERE]))},
        ),
    )


def decoded(shown: Playback, topic: str) -> list[Any]:
    """Return the messages on a topic, as a reader of the format finds them in a file."""
    content, context = io.BytesIO(), foxglove.Context()
    with foxglove.open_mcap(content, context=context):
        channel = foxglove.channels.SceneUpdateChannel(topic, context=context)
        for time, at, message in scene_messages(shown):
            if at == topic:
                channel.log(message, log_time=nanoseconds(time))
    content.seek(0)
    reader = make_reader(content, decoder_factories=[DecoderFactory()])
    return [message for *_, message in reader.iter_decoded_messages()]


def entities(shown: Playback, topic: str) -> list[Any]:
    return [message.entities[0] for message in decoded(shown, topic) if message.entities]


def test_solids_of_one_name_are_entities_of_their_own() -> None:
    shown = recorded((0.0, 0.0, 0.0), "wall", "pillar", "wall", "wall 1")
    ids = [entity.id for entity in entities(shown, "/scenery")]
    assert ids == ["wall 2", "pillar", "wall 3", "wall 1"]
    gone = [message.deletions[0].id for message in decoded(shown, "/scenery") if message.deletions]
    assert gone == ids


def test_ids_of_different_names_are_the_names() -> None:
    assert unique_ids(["a", "b", "a 1"]) == ["a", "b", "a 1"]


@pytest.mark.parametrize("topic", ["/scenery", "/things"])
def test_without_a_map_the_world_is_shown_where_it_is(topic: str) -> None:
    """The frame of a robot without a map is at its start, here at (1, 1), turned to the left."""
    (entity,) = entities(recorded((1.0, 1.0, math.pi / 2), "wall"), topic)
    at = entity.cubes[0].pose.position
    assert (at.x, at.y, at.z) == pytest.approx((2.0, 0.0, 0.5))


def test_unknown_poses_stay_unknown_on_the_map() -> None:
    rows = np.array([HERE, [math.nan] * 7])
    found = on_map(recorded((1.0, 1.0, 0.0)), rows)
    assert found[0] == pytest.approx([0.0, 2.0, *HERE[2:]])
    assert np.isnan(found[1]).all()
