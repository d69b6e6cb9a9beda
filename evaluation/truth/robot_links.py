"""Which part of the robot a link belongs to."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.backends.simulation.body.arm_contact import HELD
from handcart.primitives.contract.meant_contact import RobotPart
from handcart.robotics.kinematics.arm_model import ArmModel

FINGERS = "fingers"  # both together, as one that pushes


class RobotLinks:
    """Sorts the names that contacts give to bodies of the robot."""

    def __init__(self, arm: ArmModel | None) -> None:
        """Of a robot with this arm, or none."""
        self._arm = set() if arm is None else _moved(arm, 0)
        self._hand = {FINGERS} if arm is None else {FINGERS, "hand", *_moved(arm, arm.dof - 1)}

    def part(self, body: str) -> RobotPart:
        """Of a body by its name in a contact; what stands on the robot counts as its base."""
        if body == HELD:
            return "held"
        if body in self._hand:
            return "hand"
        return "arm" if body in self._arm else "base"


def _moved(arm: Any, first: int) -> set[str]:
    """Links that some joint from number `first` on moves."""
    here = 0.5 * (arm.lower + arm.upper)
    there = here + np.where(np.arange(arm.dof) >= first, 0.1, 0.0)
    names = [shape.name for shape in arm.link_shapes(here)]
    poses = zip(names, arm.link_poses(here).copy(), arm.link_poses(there), strict=True)
    return {name for name, one, other in poses if not np.allclose(one, other)}
