"""Contacts of the robot, and their forces."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from handcart.backends.physics.engine.engine import Engine, Touching
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.simulation.body.arm_contact import LOAD_NAME
from handcart.robotics.numerics.arrays import FloatArray

from .robot_body import RobotBody

Pairs = frozenset[tuple[str, str]]
Asked = tuple[Collection[Touching], Collection[Touching], int | None, Collection[int]]
FINGER_LINKS = ("left_finger", "right_finger")
_ACROSS = 0.7  # of a contact's normal; less is a push with the tips


class ContactReader:
    """Reader of what the robot touches and grips, and of the force on its hand, in a physics engine.

    The hand consists of all links that the arm's last joint moves.
    """

    def __init__(self, engine: Engine, body: RobotBody, world: WorldBodies, last_joint: str | None) -> None:
        self._engine, self._body, self._world = engine, body, world
        self._hand = set() if last_joint is None else body.links_behind(last_joint)
        self._rolling = {*body.casters, *body.rolling}
        self._fingers = [body.link_index[name] for name in FINGER_LINKS if name in body.link_index]
        self._read: dict[int, Collection[Touching]] = {}
        self._asked: Asked | None = None
        """Inputs of the cached pairs; the next step of the engine usually leaves them unchanged."""
        self._pairs: Pairs = frozenset()

    def stepped(self) -> None:
        """Discard the cached contacts, because the engine has made a step."""
        self._read.clear()

    def gripped(self) -> int | None:
        """Return the engine's number of the thing on which both fingers press from opposite sides; None
        without one.
        """
        if not self._fingers:
            return None
        across = self._body.link_pose("hand")[:3, 1]
        if not {item.link for item in self._touching(self._body.id)} >= set(self._fingers):
            return None
        points = self._engine.contacts(self._body.id)
        sides = [
            {point.other for point in points if point.link == finger and abs(across @ point.normal) > _ACROSS}
            for finger in self._fingers
        ]
        both = set.intersection(*sides)
        return min(both & set(self._world.bodies.values()), default=None)

    def force(self, held: int | None) -> FloatArray:
        """Return the force (3,) of the surroundings on the hand and the held object, in the world frame, in
        [N].

        Args:
            held: body of the held object; None: the hand is empty.
        """
        total, mine, hand = np.zeros(3), self._body.id, self._hand
        if held in self._world.fixed:
            return self._force_of_fixed()
        if any(item.link in hand and item.other not in (held, mine) for item in self._touching(mine)):
            for point in self._engine.contacts(mine):
                if point.link in hand and point.other not in (held, mine):
                    total += point.force
        if held is not None and any(
            item.other != mine or item.other_link not in hand for item in self._touching(held)
        ):
            for point in self._engine.contacts(held):
                if point.other != mine or point.other_link not in hand:
                    total += point.force
        return total

    def _force_of_fixed(self) -> FloatArray:
        """Return the force (3,) on the hand, in the world frame, in [N], while it holds a body on a joint of
        the world.
        """
        total = self._engine.pin_force()
        for point in self._engine.contacts(self._body.id):
            if point.link in self._hand and point.other != self._body.id:
                total = total + point.force
        return total

    def pairs(self, held: int | None, riding: Collection[int]) -> Pairs:
        """Return the names of the touching pairs: a link, "base" or the held object, and the other body.

        Args:
            held: engine's number of the held object; None: the hand is empty.
            riding: engine's numbers of the bodies that lie on the robot, whose contacts with links other than
                the hand's are left out.
        """
        its = self._touching(held) if held is not None else ()
        asked = self._touching(self._body.id), its, held, riding
        if asked != self._asked:
            self._asked, self._pairs = asked, frozenset(self._named(*asked))
        return self._pairs

    def _named(
        self, mine: Collection[Touching], its: Collection[Touching], held: int | None, riding: Collection[int]
    ) -> Iterator[tuple[str, str]]:
        """Yield touching pairs as names: a link of the robot or the held object, and the other body.

        Args:
            mine: touching pairs of the robot's links.
            its: touching pairs of the held object.
            held: engine's number of the held object; None: the hand is empty.
            riding: engine's numbers of the bodies that lie on the robot.
        """
        for point in mine:
            link, other = self._body.link_names[point.link], point.other
            if other in (held, self._body.id) or (
                link in self._rolling and self._world.names[other] == "floor"
            ):
                continue
            if other not in riding or point.link in self._hand:
                yield link, self._world.names[other]
        for point in its:
            if point.other != self._body.id:
                yield LOAD_NAME, self._world.names[point.other]

    def _touching(self, body: int) -> Collection[Touching]:
        if body not in self._read:
            self._read[body] = self._engine.touching(body)
        return self._read[body]
