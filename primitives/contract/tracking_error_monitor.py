"""Whether the arm goes where it is told."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot

from .discrepancy import Discrepancy, Measured

LATE = 5  # periods by which joints may follow late
BEHIND = 0.02  # [rad] that a joint may be off all that it was told in these: contacts bend it so far
IN_A_ROW = 3  # periods of it: a single reading may be broken


class TrackingErrorMonitor:
    """Compares the joints' readings with their commands, period by period.

    An arm that is stuck, and encoders that stand still while it moves, look alike here: neither can be
    worked with.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._commands: deque[NDArray[np.float64]] = deque(maxlen=LATE)
        self._off = 0

    def check(self) -> None:
        """Once a period; raises `Discrepancy` where a joint is not where it was told to be."""
        arm = self._robot.backend.get(Arm)  # type: ignore[type-abstract]
        if arm is None:
            return
        self._commands.append(arm.command())
        if len(self._commands) < LATE:
            return
        joints, commanded = arm.joints(), np.array(self._commands)
        off = np.maximum(commanded.min(axis=0) - joints, joints - commanded.max(axis=0))
        self._off = 0 if bool((off <= BEHIND).all()) else self._off + 1  # NaN is off too
        if self._off >= IN_A_ROW:
            number = int(np.argmax(off)) + 1
            raise Discrepancy(
                f"joint {number} is {off.max():.2f} rad from where it was told to be",
                measured=Measured("Arm", f"joint {number} off its command", float(off.max()), BEHIND, "rad"),
                check="following",
            )
