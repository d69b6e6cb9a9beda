"""Postures that a person taught, instead of planned ones."""

from __future__ import annotations

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.numerics.arrays import FloatArray


def taught_postures(robot: Robot, name: str, fewest: int) -> list[FloatArray]:
    """Return the postures `name_1`, `name_2`, ... of the robot's file, each (n,) in [rad] or [m].

    Raises:
        Discrepancy: fewer than `fewest` were taught; the message says how to teach them.
    """
    postures = {} if robot.spec.arm is None else robot.spec.arm.postures
    found: list[FloatArray] = []
    while f"{name}_{len(found) + 1}" in postures:
        found.append(np.array(robot.spec.posture(f"{name}_{len(found) + 1}")))
    if len(found) < fewest:
        missing = ", ".join(f"{name}_{number}" for number in range(len(found) + 1, fewest + 1))
        raise Discrepancy(
            f"not taught yet: {missing} (handcart teach {name})", permanent=True, cause=causes.NOT_KNOWN
        )
    return found
