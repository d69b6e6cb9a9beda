"""Indices of the engine's bodies in MuJoCo's arrays."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, IntArray

_NOBODY = (-1, -1)


class ThingNumbers(NamedTuple):
    """MuJoCo's indices of a thing's body and joint."""

    body: int
    position: int
    """Index of its seven coordinates."""
    velocity: int
    geometries: tuple[int, ...]


class Numbering:
    """Owners of a compiled model's geometries, and indices of the coordinates of things.

    Geometries of bodies other than the robot's are named by the engine's numbers: `7`, `7.1`.
    """

    def __init__(self, model: Any, links: Mapping[int, tuple[int, int]], things: Collection[int]) -> None:
        """Assign numbers to the geometries and things of a model.

        Args:
            model: MuJoCo's model.
            links: engine's body and link of each body of the robot, by MuJoCo's number.
            things: the engine's numbers of bodies that move freely.
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
            joint = model.joint(f"{number}")
            self.things[number] = ThingNumbers(
                int(joint.bodyid[0]), int(joint.qposadr[0]), int(joint.dofadr[0]), tuple(mine[number])
            )
        self._numbers = np.array(list(self.things), np.int64)
        first = np.array([each.position for each in self.things.values()], np.int64)
        self._where: IntArray = first[:, None] + np.arange(7)

    def moved(self, changed: BoolArray) -> frozenset[int]:
        """Things of which some of all coordinates (n,) have `changed`."""
        return frozenset(self._numbers[changed[self._where].any(axis=1)].tolist())
