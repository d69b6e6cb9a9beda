"""Record of a motion, period by period: the way back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray


class Moment(NamedTuple):
    """State of the robot in one period: base, arm and gripper."""

    pose: Pose2
    """map_T_base as estimated."""
    joints: FloatArray
    """(n,) commanded, in [rad]; (0,) without an arm."""
    grip: float
    """Commanded opening, in [m]; 0 without a gripper."""
    odometry_pose: Pose2 | None = None
    """The base by what doesn't jump (`Localization.odometry_pose`)."""


NEAR_PERIODS = 200  # the last ones, in which a place is looked for
RAD_M = 0.3  # that a turn of a radian counts as, in [m]


class Trace:
    """The moments of a motion, oldest first."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.moments: list[Moment] = []

    def nearest(self, pose: Pose2) -> int:
        """Return the number of the moment whose base was nearest to a pose, among the last ones."""
        begin = max(0, len(self.moments) - NEAR_PERIODS)
        poses = [each.odometry_pose or each.pose for each in self.moments[begin:]]
        off = [each.distance(pose) + RAD_M * each.turn(pose) for each in poses]
        return begin + int(np.argmin(off))

    def cut_to(self, robot: Robot) -> None:
        """Let the base come from its current pose on its way in; its later motion is not retraced.

        Arm and gripper keep their moments.
        """
        pose, odometry_pose = robot.pose, robot.localization.odometry_pose
        for number in range(self.nearest(odometry_pose) + 1, len(self.moments)):
            self.moments[number] = self.moments[number]._replace(pose=pose, odometry_pose=odometry_pose)

    def record(self) -> None:
        """Record the robot's state in this period."""
        arm = self._robot.backend.get(Arm)  # type: ignore[type-abstract]
        gripper = self._robot.backend.get(Gripper)  # type: ignore[type-abstract]
        joints = arm.command().copy() if arm else np.empty(0)
        grip = gripper.command() if gripper else 0.0
        self.moments.append(Moment(self._robot.pose, joints, grip, self._robot.localization.odometry_pose))
