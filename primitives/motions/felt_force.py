"""The force on the hand, with periods in which the sensor reads no number."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.numerics.arrays import FloatArray

MAX_SILENT_PERIODS = 5
"""Maximum number of periods in a row without a number, after which the sensor counts as faulty."""


class FeltForce:
    """Reader of the force on the hand that tells a missing reading from a small force.

    NaN is neither above nor below any limit, so that a motion that compares it would press on.
    """

    def __init__(self, robot: Robot) -> None:
        """Read the force sensor of a robot's hand, or the joints' torques in its place."""
        self._robot, self._silent = robot, 0

    def read(self) -> FloatArray | None:
        """Return the force (3,) on the hand in the hand's frame, in [N]; None in a period without a number.

        To be called once a period.

        Raises:
            Discrepancy: there was no number for more than `MAX_SILENT_PERIODS` periods.
        """
        force = self._robot.arm.hand_force()
        if np.isfinite(force).all():
            self._silent = 0
            return force
        self._silent += 1
        if self._silent > MAX_SILENT_PERIODS:
            raise Discrepancy("the force on the hand isn't measured", cause=causes.SENSOR_FAULT)
        return None


def awaited_force(robot: Robot) -> Generator[None, None, FloatArray]:
    """Return the force (3,) on the hand in the hand's frame, in [N]; the arm holds until a number is read.

    Raises:
        Discrepancy: no number was read for `MAX_SILENT_PERIODS` periods.
    """
    felt = FeltForce(robot)
    while (force := felt.read()) is None:
        yield
    return force
