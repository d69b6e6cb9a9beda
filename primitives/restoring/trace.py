"""Record of a motion, period by period: the way back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray


class Moment(NamedTuple):
    """State of the robot in one period: pose of the base, and commands of arm and gripper."""

    pose: Pose2
    """map_T_base as estimated."""
    joints: FloatArray
    """Commanded joints (n,), in [rad] or [m]; (0,) without an arm."""
    grip: float
    """Commanded opening, in [m]; 0 without a gripper."""
    odometry_pose: Pose2 | None = None
    """`Localization.odometry_pose` of the base, which does not jump."""


NEAR_PERIODS = 200  # the last ones, in which a place is looked for
RAD_M = 0.3  # that a turn of a radian counts as, in [m]
JOINT_M = 0.5  # that a radian of a joint counts as, in [m]
STEP_ROUNDING = 1e-6  # of a period
GRIP_WEIGHT = 100.0  # of the fingers' opening: a motion of theirs is never skipped


class Trace:
    """Record of a motion of the robot, one `Moment` (base, arm and fingers) in each period, oldest first."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.moments: list[Moment] = []
        self.is_rest = False
        """True if it is what is left of another trace, along which a motion back was broken off."""

    def nearest(self, pose: Pose2) -> int:
        """Return the index of the recorded moment at which the base was nearest to a pose, among the last
        `NEAR_PERIODS` moments.

        Args:
            pose: pose in the frame of `Localization.odometry_pose`.
        """
        begin = max(0, len(self.moments) - NEAR_PERIODS)
        poses = [moment.odometry_pose or moment.pose for moment in self.moments[begin:]]
        off = [item.distance(pose) + RAD_M * item.turn(pose) for item in poses]
        return begin + int(np.argmin(off))

    def cut_to(self, robot: Robot) -> None:
        """Remove the base's path since the recorded moment nearest to its present pose, so that it isn't
        retraced.

        All later moments get the present pose of the base. Their states of arm and gripper are kept.
        """
        pose, odometry_pose = robot.pose, robot.localization.odometry_pose
        for number in range(self.nearest(odometry_pose) + 1, len(self.moments)):
            self.moments[number] = self.moments[number]._replace(pose=pose, odometry_pose=odometry_pose)

    def left_after(self, back: Trace) -> Trace:
        """Return the trace that still has to be retraced if a motion back along this trace ended early.

        The result is the part of this trace that was not retraced, followed by the part of the motion back
        that deviated from this trace.

        Args:
            back: record of the motion back.
        """
        last, begin = len(self.moments) - 1, 0
        for number, moment in enumerate(back.moments):
            before = last
            while last > 0 and _apart(self.moments[last - 1], moment) <= _apart(self.moments[last], moment):
                last -= 1
            begin = number if last < before else begin
        left = Trace(self._robot)
        left.moments = _small_steps(self._robot, [*self.moments[: last + 1], *back.moments[begin:]])
        left.is_rest = bool(left.moments)
        return left

    def record(self) -> None:
        """Append the robot's state in this period (base, arm and gripper) to the record."""
        arm = self._robot.backend.get(Arm)  # type: ignore[type-abstract]
        gripper = self._robot.backend.get(Gripper)  # type: ignore[type-abstract]
        joints = arm.command().copy() if arm else np.empty(0)
        grip = gripper.command() if gripper else 0.0
        self.moments.append(Moment(self._robot.pose, joints, grip, self._robot.localization.odometry_pose))


def _small_steps(robot: Robot, moments: Sequence[Moment]) -> list[Moment]:
    """Return the moments, with further ones between two whose joints differ by more than a period's motion.

    A stuck arm accepts commands that it could not follow.
    """
    found = list(moments[:1])
    for before, after in pairwise(moments):
        step = after.joints - before.joints
        periods = float((np.abs(step) / (robot.joint_speeds * robot.period)).max()) if len(step) else 1.0
        count = max(1, math.ceil(periods - STEP_ROUNDING))
        between = after._replace(grip=before.grip)
        found += [between._replace(joints=before.joints + k / count * step) for k in range(1, count)]
        found.append(after)
    return found


def _apart(one: Moment, other: Moment) -> float:
    """Return the distance between the commands and poses of two moments, weighted, in [m]."""
    here, there = one.odometry_pose or one.pose, other.odometry_pose or other.pose
    joints = float(np.linalg.norm(one.joints - other.joints))
    fingers = GRIP_WEIGHT * abs(one.grip - other.grip)
    return here.distance(there) + RAD_M * here.turn(there) + JOINT_M * joints + fingers
