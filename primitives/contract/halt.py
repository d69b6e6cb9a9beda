"""Hold a robot at rest until a person comes."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import suppress

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.restoring.arm_command import hold_measured
from handcart.primitives.restoring.snapshot import settle

from .tracking_error_monitor import TRACKING_TOLERANCE_RAD

RELIEF_MAX_TRIES = 5  # commands to hold the measured pose, until the hand hardly presses
PRESSING_FORCE_N = 5.0  # on the hand: a smaller force may be the sensor's offset


def halt(robot: Robot) -> Generator[None, None, None]:
    """Stop the robot, and wait until nothing moves; if sensors fail, do not wait.

    If the hand presses on something, the arm is commanded to its measured joints, which relieves the force.
    An arm that is jammed because the base slid would otherwise push the base aside, little by little. The
    jam may follow the arm, so that the command is repeated.
    """
    robot.stop()
    with suppress(Exception):  # the GiveUp that follows has the cause; a failed reading must not hide it
        yield from settle(robot)
        arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
        for _ in range(RELIEF_MAX_TRIES):
            if arm is None or not _presses(arm):
                return
            yield from hold_measured(robot)
            yield from settle(robot)


def _presses(arm: Arm) -> bool:
    """Return whether both force and joints indicate pressing; a single broken sensor must not move the
    arm.
    """
    off = float(np.abs(arm.command() - arm.joints()).max())
    return off <= TRACKING_TOLERANCE_RAD and float(np.linalg.norm(arm.hand_force())) > PRESSING_FORCE_N
