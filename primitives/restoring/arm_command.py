"""Commanding arm and gripper as in a recorded moment."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.robotics.numerics.arrays import FloatArray

from .trace import Moment

PERIOD_ROUNDING = 1e-6  # of a period
GRIP_PAUSE = 0.6  # [s] that fingers get before anything else moves


def renew_arm(robot: Robot, moment: Moment) -> bool:
    """Command the arm to the joints of a recorded moment, unless they are its last command.

    Returns:
        True if a new command was given; False without an arm, or if no new command was needed.
    """
    arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
    if arm is None or not np.any(arm.command() != moment.joints):
        return False
    arm.move(moment.joints)
    return True


def renew_passed(robot: Robot, left: list[Moment], places: Sequence[float] | FloatArray, way: float) -> None:
    """Command the arm as it was where the base is on its way back, as far as its joints get in a period.

    Moments in which the fingers moved, and those before them, are left.

    Args:
        robot: robot whose base drives back.
        left: moments that are left to undo, oldest first; those that are undone are removed.
        places: distance of each moment of the motion from its end, in [m], oldest first.
        way: distance that the base has driven back from that end, in [m].
    """
    arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
    moment: Moment | None = None
    while left and places[len(left) - 1] <= way and not moves_fingers(robot, left[-1]):
        if moment is not None and arm is not None:
            off = np.abs(left[-1].joints - arm.command())
            if np.any(off > (1.0 + PERIOD_ROUNDING) * robot.joint_speeds * robot.period):
                break
        moment = left.pop()
    if moment is not None:
        renew_arm(robot, moment)


def hold_measured(robot: Robot) -> Generator[None, None, None]:
    """Command the arm to its measured joints, so that the hand no longer presses on its surroundings."""
    yield from _step_evenly(robot, robot.arm_model.clipped(robot.arm.joints()))


def rejoin(robot: Robot, moment: Moment) -> Generator[None, None, None]:
    """Move the arm to the joints commanded in a recorded moment, on a straight line in joint space.

    The motion starts at the current command and stays within the robot's joint speeds. The two commands
    differ, for example, if the arm was held still after an interrupted motion.
    """
    arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
    if arm is None or np.array_equal(arm.command(), moment.joints):
        return
    yield from _step_evenly(robot, robot.arm_model.nearest(moment.joints, arm.command()))


def _step_evenly(robot: Robot, goal: FloatArray) -> Generator[None, None, None]:
    arm, start = robot.arm, robot.arm.command()
    periods = float(np.nan_to_num(np.abs(goal - start) / (robot.joint_speeds * robot.period)).max())
    for share in np.linspace(1.0, 0.0, max(1, math.ceil(periods - PERIOD_ROUNDING)), endpoint=False)[::-1]:
        arm.move(goal if share == 1.0 else start + share * (goal - start))
        yield


def moves_fingers(robot: Robot, moment: Moment) -> bool:
    """Return whether the fingers' command at a moment of a recorded motion differs from the current
    command.
    """
    gripper = robot.backend.get(Gripper)  # type: ignore[type-abstract]
    return gripper is not None and abs(gripper.command() - moment.grip) > 1e-6


def command_moment(robot: Robot, moment: Moment, periods: int = 1) -> Generator[None, None, None]:
    """Bring the gripper, and then the arm, to the commands that they had in a recorded moment.

    Args:
        robot: the robot.
        moment: recorded state.
        periods: number of periods over which the arm's motion is spread evenly.
    """
    if moves_fingers(robot, moment):
        robot.gripper.move(moment.grip)
        yield from robot.wait(GRIP_PAUSE)
    arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
    start = moment.joints if arm is None else arm.command()
    end = moment.joints if arm is None else robot.arm_model.nearest(moment.joints, start)
    for share in np.linspace(0.0, 1.0, periods + 1)[1:]:
        if renew_arm(robot, moment._replace(joints=start + share * (end - start))):
            yield
