"""Indices of the engine's bodies in MuJoCo's arrays."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, IntArray

from .mujoco_module import mujoco

FREE_COORDINATES = 7  # of a body that moves freely: its place and its orientation
_NOBODY = (-1, -1)


class ThingNumbers(NamedTuple):
    """Indices of a thing's body, joint coordinates and geometries in a compiled model of MuJoCo."""

    body: int
    position: int
    """Index of the thing's first coordinate in `qpos`."""
    velocity: int
    geometries: tuple[int, ...]
    coordinates: int
    """Number of the thing's coordinates in `qpos`: 7 for a free body, 1 on a joint of the world."""


class Numbering:
    """Assignment between MuJoCo's indices in a compiled model and the project's own numbers of bodies.

    It knows the body and link of each geometry, and the coordinates of each movable thing. Geometries of the
    robot have any name; those of another body have the body's number as their name, such as `7`, or `7.1` for
    a further geometry.
    """

    def __init__(self, model: Any, links: Mapping[int, tuple[int, int]], things: Collection[int]) -> None:
        """Assign numbers to the geometries and things of a model.

        Args:
            model: MuJoCo's model.
            links: engine's body and link of each body of the robot, by MuJoCo's number.
            things: the engine's numbers of bodies that move freely, or with a joint of the world.
        """
        self.owners: list[tuple[int, int]] = [_NOBODY] * int(model.ngeom)
        """Body and link of each geometry; -1 without a link."""
        mine: dict[int, list[int]] = {}
        for geometry in range(model.ngeom):
            body, name = int(model.geom_bodyid[geometry]), model.geom(geometry).name.partition(".")[0]
            if body in links:
                self.owners[geometry] = links[body]
            elif name.isdigit():
                self.owners[geometry] = int(name), -1
                mine.setdefault(int(name), []).append(geometry)
        self.things: dict[int, ThingNumbers] = {}
        for number in things:
            self.things[number] = _numbers(model, number, tuple(mine[number]))
        self._numbers = np.array(list(self.things), np.int64)
        first, last = (
            np.array(
                [thing.position + less * (thing.coordinates - 1) for thing in self.things.values()], np.int64
            )
            for less in (0, 1)
        )
        self._where: IntArray = np.minimum(first[:, None] + np.arange(FREE_COORDINATES), last[:, None])

    def moved(self, changed: BoolArray) -> frozenset[int]:
        """Return the numbers of the things that moved, by a mask (n,) of changed joint coordinates (MuJoCo's
        `qpos`).
        """
        return frozenset(self._numbers[changed[self._where].any(axis=1)].tolist())


def _numbers(model: Any, number: int, geometries: tuple[int, ...]) -> ThingNumbers:
    """Return the indices of a thing; a thing that is fixed to another one has the other one's joint."""
    body = int(model.body(f"{number}").id)
    carrier = body if model.body_jntnum[body] else int(model.body_parentid[body])
    joint = int(model.body_jntadr[carrier])
    free = model.jnt_type[joint] == mujoco().mjtJoint.mjJNT_FREE
    position, velocity = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    return ThingNumbers(body, position, velocity, geometries, FREE_COORDINATES if free else 1)
