"""Surroundings and carried things of a recorded run, as Foxglove scene entities."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.evaluation.viewing.playback.scenery import Size
from handcart.evaluation.viewing.playback.seven import sevens, transforms
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .stamped import MAP_FRAME, Message, pose_of, stamp

if TYPE_CHECKING:
    from foxglove.messages import SceneEntity

FURNITURE_GREY = 178  # of solids without a grey value


def scene_messages(recorded: Playback) -> Iterator[Message]:
    """Yield the recorded world as Foxglove scene messages.

    Fixed boxes are on the topic `/scenery` when they appear or disappear; movable things are on `/things`
    when they move. Poses are in the map's frame.
    """
    yield from _scenery(recorded)
    for name, track in recorded.things.items():
        (middle,) = transforms(np.array([track.shape.middle]))
        poses = on_map(recorded, sevens(transforms(track.pose) @ middle))
        for time, pose in zip(track.time.tolist(), poses, strict=True):
            yield _update(time, "/things", _box(name, time, pose, track.shape.size_m, track.shape.grey))


def _scenery(recorded: Playback) -> Iterator[Message]:
    from foxglove.messages import SceneEntityDeletion, SceneUpdate

    rows, solids = recorded.rows, recorded.scenery.solids
    ids = unique_ids([solid.name for solid in solids])
    for solid, id_ in zip(solids, ids, strict=True):
        appears, leaves = solid.appears_s, solid.leaves_s
        if appears > rows.world_time[-1]:
            continue
        time = float(np.interp(appears, rows.world_time, rows.time))
        grey = FURNITURE_GREY if solid.grey is None else solid.grey
        (pose,) = on_map(recorded, np.array([solid.pose]))
        yield _update(time, "/scenery", _box(id_, time, pose, solid.size_m, grey))
        if leaves is not None and leaves <= rows.world_time[-1]:
            gone = float(np.interp(leaves, rows.world_time, rows.time))
            deletion = SceneEntityDeletion(timestamp=stamp(gone), id=id_)
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


def on_map(recorded: Playback, poses: FloatArray) -> FloatArray:
    """Convert poses (n, 7) from the world's frame to the map's, both as x, y, z in [m] and a quaternion w, x,
    y, z.

    The frames differ only in runs without a map. Rows with NaN stay as they are.
    """
    frame = Pose2(*recorded.scenery.world_t_map)
    known = np.isfinite(poses).all(axis=1)
    if frame == Pose2(0.0, 0.0, 0.0) or not known.any():
        return poses
    found = poses.copy()
    found[known] = sevens(frame.inverse().lift() @ transforms(poses[known]))
    return found


def unique_ids(names: Sequence[str]) -> list[str]:
    """Return an id for each name: of entities with the same id, a viewer shows the last alone.

    A name that occurs once is its own id; the others are numbered from 1.
    """
    counts, seen = Counter(names), Counter[str]()
    taken = {name for name in counts if counts[name] == 1}
    ids = []
    for name in names:
        id_ = name
        while counts[name] > 1:
            seen[name] += 1
            id_ = f"{name} {seen[name]}"
            if id_ not in taken:
                break
        ids.append(id_)
    return ids
