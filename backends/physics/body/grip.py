"""Grip of a thing between the pads."""

from __future__ import annotations

from typing import Literal

import numpy as np

from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.physics.engine.engine import Engine, Pinned, Point
from handcart.backends.physics.engine.surface import PAD_SURFACE, ContactSurface
from handcart.backends.physics.world.thing_body import THING_FRICTION
from handcart.backends.simulation.world.grasp import PAD_FRICTION
from handcart.backends.urdf.robot_shape import FingerShape
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.numerics.arrays import FloatArray

from .robot_body import RobotBody

BEHIND_TIP = (0.01, 0.04)  # of the points along a finger [m]
PAD_HEIGHT_RATIO = 0.375  # of a finger's height, above and below its middle
SLIP_LEAD_M = 0.0005  # [m] by which a point that slips runs ahead of the pads
CONSTRAINT_FORCE_N = 500.0  # with which a constraint holds at each point [N]


class Grip:
    """Connection between the hand and a thing on which both fingers press, at points of the finger pads.

    With the grasp `friction` (key `gripper.grasp` of the robot's file) the thing is held as soft fingers hold
    it (Howe and Cutkosky 1996). The points and the engine's own contacts together carry forces along the
    pads, and torques about the pads' normal, up to the limit of Coulomb's friction. Under a larger load the
    thing slips. The engine's contacts carry the share `Engine.CONTACTS_CARRY` of this limit. With the grasp
    `constraint` nothing slips.
    """

    def __init__(self, spec: GripperSpec, finger: FingerShape, engine: Engine, body: RobotBody) -> None:
        self._engine, self._body = engine, body
        self._hand = body.link_index["hand"]
        self._kind: Literal["friction", "constraint"] = spec.grasp
        coulomb = (1.0 - engine.CONTACTS_CARRY) * PAD_FRICTION * THING_FRICTION * 2 * spec.force_n
        up = PAD_HEIGHT_RATIO * finger.height
        hand = np.array([(finger.tip - back, 0.0, z, 1.0) for back in BEHIND_TIP for z in (up, -up)])
        self._force = coulomb / len(hand) if spec.grasp == "friction" else CONSTRAINT_FORCE_N
        middle_T_hand = inverse(body.middle_of_mass("hand")) @ body.link_pose("hand")
        self._points = (hand @ middle_T_hand.T)[:, :3]

    @property
    def holds(self) -> int | None:
        """Number of the held body in the engine; None if no body is held."""
        pinned = self._engine.pinned
        return None if pinned is None else pinned.other

    def take(self, other: int) -> None:
        """Fix the engine's body with the number `other` to the hand, at the body's current pose."""
        there = self._there(other)
        pinned = self._engine.pinned
        if pinned is not None and pinned.other == other:
            run = np.linalg.norm(there - np.array(pinned.other_points), axis=1).max()
            if self._kind == "constraint" or run < SLIP_LEAD_M:
                return
        self._engine.pin(
            Pinned(self._body.id, self._hand, other, _tuples(self._points), _tuples(there), self._force)
        )

    def let_go(self) -> None:
        """Release the held body."""
        if self.holds is not None:
            self._engine.pin(None)

    def _there(self, other: int) -> FloatArray:
        """Return the pads' points (n, 3) in the frame of the other body's middle of mass, in [m]."""
        other_T_hand = inverse(self._engine.pose(other)) @ self._body.middle_of_mass("hand")
        return np.asarray((np.c_[self._points, np.ones(len(self._points))] @ other_T_hand.T)[:, :3])


def pads_in(engine: Engine) -> ContactSurface:
    """Return the contact surface of the fingers in an engine.

    The surface has only the share `Engine.CONTACTS_CARRY` of the pads' friction; `Grip` simulates the rest.
    """
    return PAD_SURFACE._replace(friction=engine.CONTACTS_CARRY * PAD_FRICTION)


def _tuples(points: FloatArray) -> tuple[Point, ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in points)
