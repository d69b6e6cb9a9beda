"""Surroundings and carried things of a recorded run, as Foxglove scene entities."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.evaluation.viewing.playback.scenery import Size
from handcart.evaluation.viewing.playback.seven import sevens, transforms
from handcart.robotics.numerics.arrays import FloatArray

from .stamped import MAP_FRAME, Message, pose_of, stamp

if TYPE_CHECKING:
    from foxglove.messages import SceneEntity

FURNITURE_GREY = 178  # of solids without a grey value


def scene_messages(recorded: Playback) -> Iterator[Message]:
    """Yield the recorded world as Foxglove scene messages.

    Fixed boxes are on the topic `/scenery` when they appear or disappear; movable things are on `/things`
    when they move.
    """
    yield from _scenery(recorded)
    for name, track in recorded.things.items():
        (middle,) = transforms(np.array([track.shape.middle]))
        poses = sevens(transforms(track.pose) @ middle)
        for time, pose in zip(track.time.tolist(), poses, strict=True):
            yield _update(time, "/things", _box(name, time, pose, track.shape.size_m, track.shape.grey))


def _scenery(recorded: Playback) -> Iterator[Message]:
    from foxglove.messages import SceneEntityDeletion, SceneUpdate

    rows = recorded.rows
    for solid in recorded.scenery.solids:
        appears, leaves = solid.appears_s, solid.leaves_s
        if appears > rows.world_time[-1]:
            continue
        time = float(np.interp(appears, rows.world_time, rows.time))
        grey = FURNITURE_GREY if solid.grey is None else solid.grey
        yield _update(time, "/scenery", _box(solid.name, time, np.array(solid.pose), solid.size_m, grey))
        if leaves is not None and leaves <= rows.world_time[-1]:
            gone = float(np.interp(leaves, rows.world_time, rows.time))
            deletion = SceneEntityDeletion(timestamp=stamp(gone), id=solid.name)
            yield gone, "/scenery", SceneUpdate(deletions=[deletion])


def _update(time: float, topic: str, entity: SceneEntity) -> Message:
    from foxglove.messages import SceneUpdate

    return time, topic, SceneUpdate(entities=[entity])


def _box(name: str, time: float, pose: FloatArray, size: Size, grey: int) -> SceneEntity:
    from foxglove.messages import Color, CubePrimitive, SceneEntity, Vector3

    shade = grey / 255
    cube = CubePrimitive(
        pose=pose_of(pose),
        size=Vector3(x=size[0], y=size[1], z=size[2]),
        color=Color(r=shade, g=shade, b=shade, a=1.0),
    )
    return SceneEntity(timestamp=stamp(time), frame_id=MAP_FRAME, id=name, cubes=[cube])
