"""What the robot touches, and with what force."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handcart.backends.pybullet.physics import Physics
from handcart.backends.pybullet.world.world_bodies import WorldBodies
from handcart.backends.simulation.body.arm_contact import HELD

from .robot_body import RobotBody

Pairs = frozenset[tuple[str, str]]
FINGERS = ("left_finger", "right_finger")
_ACROSS = 0.7  # of a contact's normal; less is a push with the tips


class Touch:
    """Reads the engine's contact points. To the hand belongs all that the arm's last joint moves."""

    def __init__(self, physics: Physics, body: RobotBody, world: WorldBodies, last_joint: str | None) -> None:
        self._physics, self._body, self._world = physics, body, world
        self._hand = set() if last_joint is None else body.links_behind(last_joint)
        self._rolling = {*body.casters, *(name for name in body.link_index if name.endswith("wheel"))}
        self._fingers = [body.link_index[name] for name in FINGERS if name in body.link_index]
        self._read: dict[int, list[tuple[Any, ...]]] = {}

    def stepped(self) -> None:
        """The engine has moved on: what was read of it is old."""
        self._read.clear()

    def gripped(self) -> int | None:
        """Body of the thing that both fingers touch from its two sides."""
        if not self._fingers:
            return None
        across = self._body.link_pose("hand")[:3, 1]
        points = self._points(self._body.id)
        sides = [
            {each[2] for each in points if each[3] == finger and abs(across @ each[7]) > _ACROSS}
            for finger in self._fingers
        ]
        both = set.intersection(*sides)
        return min(both & set(self._world.bodies.values()), default=None)

    def force(self, held: int | None) -> NDArray[np.float64]:
        """What the surroundings put on the hand and what it holds, (3,) in [N], in the world."""
        total = np.zeros(3)
        for point in self._points(self._body.id):
            if point[3] in self._hand and point[2] not in (held, self._body.id):
                total += _force(point)
        if held is not None:
            for point in self._points(held):
                if point[2] != self._body.id or point[4] not in self._hand:
                    total += _force(point)
        return total * self._physics.substeps

    def pairs(self, held: int | None, riding: Collection[int]) -> Pairs:
        """Names of what touches now: a link, "base" or what is held, and what it ran into.

        Args:
            held: the body in the hand.
            riding: bodies that stand on the robot.
        """
        found = set()
        for point in self._points(self._body.id):
            link, other = self._body.link_names[point[3]], point[2]
            if other in (held, self._body.id) or (
                link in self._rolling and self._world.names[other] == "floor"
            ):
                continue
            if other not in riding or point[3] in self._hand:
                found.add((link, self._world.names[other]))
        for point in self._points(held) if held is not None else ():
            if point[2] != self._body.id:
                found.add((HELD, self._world.names[point[2]]))
        return frozenset(found)

    def _points(self, body: int) -> list[tuple[Any, ...]]:
        if body not in self._read:
            self._read[body] = [point for point in self._physics.contacts(body) if point[9] > 0.0]
        return self._read[body]


def _force(point: tuple[Any, ...]) -> NDArray[np.float64]:
    """On the first body of a contact point."""
    normal, along, across = (np.array(point[i]) for i in (7, 11, 13))
    return np.asarray(point[9] * normal + point[10] * along + point[12] * across)
