"""How a robot comes to hold still until a person comes."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import suppress

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.restoring.arm_command import hold_measured
from handcart.primitives.restoring.snapshot import settle

from .tracking_error_monitor import BEHIND

EASED = 5  # times that a hand which presses is told to stay where it stands, until it hardly presses
PRESSES = 5.0  # [N] on the hand: less is none, for a reading that is off


def halt(robot: Robot) -> Generator[None, None, None]:
    """Stop, and wait until nothing moves any more; where that can't be read, there is nothing to wait for.

    A hand that presses is told to stay where it stands: jammed by a base that slid, say, an arm that goes on
    to where it was told to be pushes the base aside, little by little. What it was jammed in follows, so it
    is told so again.
    """
    robot.stop()
    with suppress(Exception):
        yield from settle(robot)
        arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
        for _ in range(EASED):
            if arm is None or not _presses(arm):
                return
            yield from hold_measured(robot)
            yield from settle(robot)


def _presses(arm: Arm) -> bool:
    """Whether force and joints both say so: of one that is broken alone, nothing is to move."""
    off = float(np.abs(arm.command() - arm.joints()).max())
    return off <= BEHIND and float(np.linalg.norm(arm.hand_force())) > PRESSES
