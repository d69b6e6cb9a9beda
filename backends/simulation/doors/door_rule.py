"""A hand without physics that holds a handle."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.body.sliding import push_out
from handcart.backends.simulation.world.hand_rule import ARM_STIFFNESS_N_M, HandRule, Met
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Thing
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .door_part import HANDLE, DoorPart, middle_of, part_at

ROUNDS = 3  # of the arm's inverse kinematics
NOTHING_HELD = np.zeros(3)


class DoorRule(HandRule):
    """Rule that keeps a held handle on the path of its door.

    The motion is quasi-static, and the arm acts as a spring. The door moves as soon as the spring pulls
    harder along the path than the friction of the door; across the path, and at the stops, the door does not
    yield. The hand turns freely about the bar.
    """

    STATE: ClassVar[Kinds] = {"grip": FloatArray}

    def __init__(
        self,
        scene: Scene,
        arm: ArmModel,
        opening_of: Callable[[str], float],
        put: Callable[[str, float], None],
        base_gap: Callable[[], tuple[float, str]],
    ) -> None:
        """Prepare for the doors of a scene.

        Args:
            scene: the scene.
            arm: kinematics of the arm.
            opening_of: returns the opening of a door, given its name, in [rad] or [m].
            put: sets the opening of a door, given its name and the opening in [rad] or [m].
            base_gap: returns the distance from the base's body to the nearest part of a door, in [m], below
                zero if they overlap, and the name of that part.
        """
        self._scene, self._arm, self._opening_of, self._put = scene, arm, opening_of, put
        self._base_gap = base_gap
        self.grip = NOTHING_HELD
        """Middle (3,) of the held bar in the hand frame, in [m]."""

    @override
    def gripped(self, thing: Thing) -> None:
        scene = self._scene
        if isinstance(thing, DoorPart):
            middle = inverse(scene.world_T("hand")) @ np.append(middle_of(thing), 1.0)
            self.grip = np.array([middle[0], 0.0, middle[2]])  # the pads close around it

    @override
    def meet(self, start: FloatArray, joints: FloatArray) -> Met:
        scene, held = self._scene, self._scene.held
        if not isinstance(held, DoorPart):
            return Met(joints)
        world_T_base = scene.world_T_base
        pulled = apply(world_T_base @ self._arm.forward(joints), self.grip[None])[0]
        pairs = self._follow(held, pulled)
        base_T_world, end = inverse(world_T_base)[:3, :3], joints
        for _ in range(ROUNDS):
            there = apply(world_T_base @ self._arm.forward(end), self.grip[None])[0]
            end = push_out(self._arm, end, base_T_world @ (middle_of(held) - there))
        return Met(end, pairs=pairs)

    def _follow(self, held: DoorPart, pulled: FloatArray) -> frozenset[tuple[str, str]]:
        """Move the door until its friction balances the pull of the hand, or until it meets the base.

        Args:
            held: handle in the hand.
            pulled: (3,) point in the world to which the middle of the bar is commanded, in [m].

        Returns:
            The pair of the base and the part of the door that touch, if they do.
        """
        spec, opening = held.spec, self._opening_of(held.spec.name)
        joint = spec.true_joint()
        lever = 1.0 if joint.hinge is None else joint.radius
        way = lever * (joint.opening_at(pulled) - opening)
        slack = spec.friction_n / ARM_STIFFNESS_N_M
        moved = np.sign(way) * max(0.0, abs(way) - slack) / lever
        reached = min(max(opening + float(moved), spec.start), spec.stop)
        if reached == opening:
            return frozenset()
        before, _ = self._base_gap()
        self._put(spec.name, reached)
        gap, part = self._base_gap()
        if gap >= min(0.0, before):
            return frozenset()
        self._put(spec.name, opening)
        return frozenset({("base", part)})

    @override
    def carry(self, thing: Thing, world_T_hand: Transform, start: FloatArray) -> FloatArray:
        if isinstance(thing, DoorPart):
            thing.pose = part_at(thing.spec, HANDLE, self._opening_of(thing.spec.name))
            self._scene.hand_T_held = inverse(world_T_hand) @ thing.pose
        return np.zeros(3)
