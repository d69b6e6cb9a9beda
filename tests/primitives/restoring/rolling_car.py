"""Robot that rolls exactly as commanded, with an arm and fingers, for tests of the way back."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.primitives.restoring.snapshot import Snapshot, take_snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.odometry.watched_moment import Belief

PERIOD = 0.05


class Car:
    """Rolls exactly as commanded; its arm and fingers are where they were commanded to be."""

    held, share_for_people = None, 1.0

    def __init__(self, arm: bool = True) -> None:
        self.true, self.time, self.period = Pose2(0.0, 0.0, 0.0), 0.0, PERIOD
        self.joints, self.grip = np.zeros(2), 0.0
        self.drives: list[tuple[float, float]] = []
        self.arms: list[tuple[float, list[float]]] = []
        self._arm = SimpleNamespace(command=lambda: self.joints, joints=lambda: self.joints, move=self._move)
        self._gripper = SimpleNamespace(
            command=lambda: self.grip, width=lambda: self.grip, closed_on_something=lambda: False
        )
        self.gripper = SimpleNamespace(move=lambda grip: setattr(self, "grip", grip))
        self.arm = self._arm
        parts = {Arm: self._arm, Gripper: self._gripper} if arm else {}
        self.backend = SimpleNamespace(get=parts.get)
        self.base, self.drive_limits = self, DriveLimits()
        self.arm_model = SimpleNamespace(
            nearest=lambda goal, start: goal, clipped=lambda joints: np.clip(joints, -1.0, 1.0)
        )
        self.joint_speeds = np.array([0.5, 1.0])
        tolerance = SimpleNamespace(base_mm=100.0, base_deg=5.0)
        self.spec = SimpleNamespace(tolerance=tolerance, drive=SimpleNamespace(sharpest_per_m=0.8))
        self.displacement: Belief | None = None

    @property
    def pose(self) -> Pose2:
        return self.true

    @property
    def localization(self) -> Any:
        return SimpleNamespace(
            odometry_pose=self.true,
            displacement=self.displacement,
            sigma=(0.0, 0.0),
            dead_reckoned=True,
            POSE_JUMPS=False,
        )

    def drive(self, speed: float, turn_rate: float) -> None:
        self.drives.append((speed, turn_rate))
        self._rolls = (speed, turn_rate)

    _rolls = (0.0, 0.0)

    def step(self) -> None:
        speed, turn_rate = self._rolls
        self.true = self.true.compose(Pose2(speed * PERIOD, 0.0, turn_rate * PERIOD))
        self._rolls, self.time = (0.0, 0.0), self.time + PERIOD

    def wait(self, seconds: float) -> Any:
        end = self.time + seconds
        while self.time < end - 1e-9:
            yield

    def _move(self, joints: Any) -> None:
        self.joints = np.array(joints, dtype=float)
        self.arms.append((self.true.x, self.joints.round(9).tolist()))

    def play(self, periods: Any) -> int:
        """Step until it has ended; how many periods that took."""
        count = 0
        for _ in periods:
            self.step()
            count += 1
        return count

    def record(self, motion: Sequence[tuple[float, float, float]]) -> tuple[Snapshot, Trace]:
        """Drive by speed and turn rate in each period, the first joint there; forget what was commanded."""
        robot: Any = self
        start, trace = take_snapshot(robot, {}), Trace(robot)
        trace.record()
        for speed, turn_rate, joint in motion:
            self.drive(speed, turn_rate)
            self.joints = np.array([joint, 0.0])
            self.step()
            trace.record()
        self.drives.clear()
        self.arms.clear()
        return start, trace


def ramp(speed: float, periods: int, turn_rate: float = 0.0) -> list[tuple[float, float, float]]:
    return [(speed, turn_rate, 0.01 * number) for number in range(periods)]
