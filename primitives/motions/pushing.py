"""Slow straight motions of the hand that feel what they meet."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.arm_command import PERIOD_ROUNDING, hold_measured
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.manipulation.motions.motion_planner import plan_straight
from handcart.robotics.numerics.arrays import FloatArray

from .felt_force import awaited_force


class Pushed(NamedTuple):
    """Result of a push by the hand: the largest force, and whether a resistance above the limit has stopped
    it.
    """

    met: bool
    """True if the hand was stopped by a resistance above the limit."""
    force: float
    """The largest resistance that was felt on the way, in [N]."""


def push(
    robot: Robot,
    base_T_goal: Transform,
    speed: float,
    most: float,
    enough: Callable[[], bool] = lambda: False,
) -> Generator[None, None, Pushed]:
    """Move the hand in a straight line at constant speed until a resistance stops it.

    If a joint would exceed its speed limit, the hand moves more slowly. The speed should be chosen so that
    the force increases only a little in one period. With a stiffness of 2 N per mm and a period of 50 ms,
    20 mm/s add 2 N.

    Args:
        robot: robot whose arm is at its last command.
        base_T_goal: (4, 4) final pose of the hand.
        speed: speed of the hand, in [m/s].
        most: force against the direction of motion at which the hand stops, in [N].
        enough: function called every period; the push stops as soon as it returns True.

    Raises:
        Discrepancy: the arm cannot move the hand along that line, or the force on it is not measured.
    """
    arm = robot.arm_model
    path = plan_straight(arm, robot.arm.command(), base_T_goal, step=speed * robot.period)
    if path is None:
        raise Discrepancy(
            "the arm can't move the hand straight to where it is to go", cause=causes.NO_ARM_PATH
        )
    path = _within_speeds(path, robot.joint_speeds * robot.period)
    base_T_hand = arm.forward(path[0])
    way = base_T_goal[:3, 3] - base_T_hand[:3, 3]
    along = base_T_hand[:3, :3].T @ way / max(float(np.linalg.norm(way)), 1e-9)
    strongest = 0.0
    for joints in path[1:]:
        robot.arm.move(joints)
        yield
        resistance = float(-along @ (yield from awaited_force(robot)))
        strongest = max(strongest, resistance)
        if resistance > most:
            return Pushed(True, strongest)
        if enough():
            break
    return Pushed(False, strongest)


def relax(robot: Robot) -> Generator[None, None, None]:
    """Command the arm to its measured joints, so that the hand no longer presses on its surroundings."""
    yield from hold_measured(robot)


def _within_speeds(path: FloatArray, step: FloatArray) -> FloatArray:
    """Return a path (k, n) with rows added to `path` (m, n), so that no joint moves more than `step` (n,)
    between rows.

    All are joints in [rad] or [m].
    """
    rows = [path[:1]]
    for begin, end in pairwise(path):
        count = max(1, math.ceil(float((np.abs(end - begin) / step).max()) - PERIOD_ROUNDING))
        rows.append(np.linspace(begin, end, count + 1)[1:])
    return np.vstack(rows)
