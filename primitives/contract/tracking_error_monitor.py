"""Monitor that the arm follows its commands."""

from __future__ import annotations

from collections import deque

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured

MAX_LAG_PERIODS = 5  # periods by which joints may follow late
TRACKING_TOLERANCE_RAD = 0.02  # that a joint may be off all its commands in these: contacts bend it so far
IN_A_ROW = 3  # periods of it: a single reading may be broken


class TrackingErrorMonitor:
    """Monitor that detects arm joints that do not follow their commands.

    A stuck arm cannot be distinguished from frozen encoders; the arm is unusable in both cases.
    """

    def __init__(self, robot: Robot, tolerance: float = TRACKING_TOLERANCE_RAD) -> None:
        """Watch a robot whose joints may be off their commands by `tolerance`, in [rad] or [m]."""
        self._robot, self._tolerance = robot, tolerance
        self._commands: deque[list[float]] = deque(maxlen=MAX_LAG_PERIODS)
        self._off = 0

    def check(self) -> None:
        """Raise `Discrepancy` if a measured joint differs from all its latest commands by more than the
        tolerance. To be called once a period.
        """
        arm = self._robot.backend.get(Arm)  # type: ignore[type-abstract]
        if arm is None:
            return
        self._commands.append(arm.command().tolist())
        if len(self._commands) < MAX_LAG_PERIODS:
            return
        joints = arm.joints().tolist()
        if self._follows_latest(joints):
            self._off = 0
            return
        commanded = [(min(item), max(item)) for item in zip(*self._commands, strict=True)]
        follows = all(
            low - joint <= self._tolerance and joint - high <= self._tolerance
            for joint, (low, high) in zip(joints, commanded, strict=True)
        )  # NaN doesn't
        self._off = 0 if follows else self._off + 1
        if self._off >= IN_A_ROW:
            off = np.array(
                [
                    np.maximum(low - joint, joint - high)
                    for joint, (low, high) in zip(joints, commanded, strict=True)
                ]
            )
            raise self._discrepancy(int(np.argmax(off)), float(off.max()))

    def _follows_latest(self, joints: list[float]) -> bool:
        """Return whether all joints are at the latest command: then they are within the range of commands."""
        for joint, wanted in zip(joints, self._commands[-1], strict=True):
            if not abs(joint - wanted) <= self._tolerance:  # NaN neither
                return False
        return True

    def _discrepancy(self, joint: int, off: float) -> Discrepancy:
        slides = self._robot.spec.joint_units.slides[joint]
        scale, unit, digits = (1e3, "mm", 1) if slides else (1.0, "rad", 2)
        name = f"joint {joint + 1}"
        return Discrepancy(
            f"{name} is {scale * off:.{digits}f} {unit} from its command",
            measured=Measured("Arm", f"{name} off its command", scale * off, scale * self._tolerance, unit),
            check="following",
            cause=causes.NOT_FOLLOWING,
        )
