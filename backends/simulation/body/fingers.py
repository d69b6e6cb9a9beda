"""The two fingers: gripping, holding, letting go."""

from __future__ import annotations

import numpy as np

from handcart.backends.simulation.world.grasp import Pads, aside_at_pads
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.transform import inverse

from .hand import SimulatedHand

_LETS_GO = 0.001  # opening beyond a thing's thickness at which it is free


class Fingers:
    """Motion of simulated fingers that grip and release things, without dynamics.

    A thing between closing pads is first pushed by the pad that touches it first. Between both pads, it stops
    them and aligns with them, as the thing's domain defines (`Props`). It is released when the pads open by 1
    mm more than its thickness. A domain's rule (`HandRule`) can limit how far the pads can open.
    """

    def __init__(self, hand: SimulatedHand) -> None:
        self._hand, self._scene = hand, hand.scene
        self._shape = hand.scene.robot.finger_shape

    def set_width(self, width: float) -> None:
        """Move the finger pads to an opening of `width`, in [m]; a thing between the pads stops them and is
        then held.
        """
        scene = self._scene
        if scene.held is None and width < scene.width:
            thing = self._between()
            if thing is not None and width <= self._thickness(thing):
                self._grip(thing)
                return
            if thing is not None:
                self._slide(thing, width)
        if scene.held is not None:
            thick = self._thickness(scene.held)
            if width <= thick + _LETS_GO:
                scene.width = max(width, thick)
                return
            self._let_go(scene.held)
        scene.width = min(width, max(scene.width, self._room()))

    def _pads(self) -> Pads:
        return Pads(self._scene.world_T("hand"), self._scene.width, self._shape)

    def _thickness(self, thing: Thing) -> float:
        """Return the thickness of a thing between the pads, in [m]."""
        return self._scene.props_of(thing).thickness(thing, self._pads())

    def _between(self) -> Thing | None:
        """Return the thing that closing fingers meet."""
        pads = self._pads()
        return next(
            (
                thing
                for props in self._scene.props.values()
                for thing in props.things()
                if thing.rest not in (Rest.FLOOR, Rest.PERSON) and props.fits(thing, pads)
            ),
            None,
        )

    def _slide(self, thing: Thing, width: float) -> None:
        """Push a thing sideways by the finger that meets it first, as the pads close to an opening in [m]."""
        scene, pads = self._scene, self._pads()
        if not thing.FREE:
            return
        aside = aside_at_pads(thing, pads)
        over = abs(aside) + (self._thickness(thing) - width) / 2
        if over > 0.0:
            thing.pose = thing.pose.copy()
            thing.pose[:3, 3] -= np.copysign(over, aside) * pads.world_T_hand[:3, 1]
            if thing.rest is Rest.TRAY:
                thing.base_T_thing = inverse(scene.world_T_base) @ thing.pose
            scene.changes += 1

    def _grip(self, thing: Thing) -> None:
        scene, props = self._scene, self._scene.props_of(thing)
        pads = self._pads()
        scene.width = props.thickness(thing, pads)
        scene.hand_T_held = props.gripped(thing, pads)
        for rule in self._hand.rules.values():
            rule.gripped(thing)
        props.taken(thing)
        scene.held = thing
        scene.changes += 1
        self._hand.carry(scene.joints)

    def _let_go(self, thing: Thing) -> None:
        self._scene.held = None
        self._scene.props_of(thing).let_go(thing)

    def _room(self) -> float:
        """Return the largest possible opening of the fingers, in [m]; infinity if no rule limits it."""
        return min((rule.room() for rule in self._hand.rules.values()), default=float("inf"))
