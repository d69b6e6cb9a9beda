"""Appearance of a robot's links."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.robotics.numerics.arrays import FloatArray, Int32Array, SingleArray

Read = Callable[[bool], Any]
"""Function that returns the `MjSpec` of a robot, with its visuals if True."""


@dataclass(frozen=True, eq=False)
class PartLook:
    """Appearance (form, place and colour) of one visual shape of a robot's link, for rendering."""

    link: str
    kind: int
    """Kind of the shape, one of MuJoCo's `mjtGeom`."""
    size: FloatArray
    position: FloatArray
    quaternion: FloatArray
    rgba: SingleArray
    mesh: tuple[SingleArray, Int32Array] | None
    """Corners (n, 3) in the shape's frame, in [m], and triangles (m, 3) of their numbers; None for other
    kinds.
    """


def robot_looks(read: Read) -> list[PartLook]:
    """Return the visual shapes of a robot's links.

    Links without readable visual shapes are represented by their collision shapes.

    Args:
        read: function that returns the `MjSpec` of the robot, with its visual shapes if the argument is True.
    """
    try:
        model = read(True).compile()
    except ValueError as error:  # a mesh in a format that MuJoCo doesn't read, such as COLLADA
        logging.getLogger(__name__).info("visuals that can't be read: %s", error)
        model = read(False).compile()
    touches = model.geom_contype != 0
    plain = {int(body) for body in model.geom_bodyid} - set(model.geom_bodyid[~touches].tolist())
    return [
        _part(model, number)
        for number in range(model.ngeom)
        if not touches[number] or int(model.geom_bodyid[number]) in plain
    ]


def _part(model: Any, number: int) -> PartLook:
    kind = int(model.geom_type[number])
    mesh = None
    if kind == mujoco().mjtGeom.mjGEOM_MESH:
        which = int(model.geom_dataid[number])
        first, count = int(model.mesh_vertadr[which]), int(model.mesh_vertnum[which])
        face, faces = int(model.mesh_faceadr[which]), int(model.mesh_facenum[which])
        mesh = model.mesh_vert[first : first + count].copy(), model.mesh_face[face : face + faces].copy()
    return PartLook(
        model.body(int(model.geom_bodyid[number])).name,
        kind,
        model.geom_size[number].copy(),
        model.geom_pos[number].copy(),
        model.geom_quat[number].copy(),
        model.geom_rgba[number].copy(),
        mesh,
    )
