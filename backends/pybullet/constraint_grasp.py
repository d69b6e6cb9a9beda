"""A grasp that doesn't slip."""

from __future__ import annotations

from robotics.geometry.transform import inverse

from .physics import Fixed, Physics
from .robot_body import RobotBody

FORCE = 500.0  # with which it holds [N]


class ConstraintGrasp:
    """Fixes what both fingers press on to the hand, until they open: for tasks that aren't about slipping."""

    def __init__(self, physics: Physics, body: RobotBody) -> None:
        self._physics, self._body = physics, body

    @property
    def holds(self) -> int | None:
        """The body that is held."""
        fixed = self._physics.fixed
        return None if fixed is None else fixed.other

    def take(self, other: int) -> None:
        """Hold a body where it is in the hand."""
        if self.holds != other:
            world_T_middle = self._body.middle_of_mass("hand")
            there = inverse(world_T_middle) @ self._physics.pose(other)
            hand = self._body.link_index["hand"]
            self._physics.fix(Fixed(self._body.id, hand, other, there, FORCE))

    def let_go(self) -> None:
        """Hold nothing."""
        self._physics.fix(None)
