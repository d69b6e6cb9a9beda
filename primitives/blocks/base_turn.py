"""By how much the base has turned on the spot since a fixation, and how sure that is."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Fixed
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.attitude import yaw_sigma

GATE = 5.0  # sigmas


class BaseTurn(NamedTuple):
    """A turn of the base, and its sigma, in [rad]."""

    yaw: float
    sigma: float


def turn_by_model(robot: Robot, swings: int) -> BaseTurn:
    """What the suspension's model says of so many swings of the loaded arm (Hatano et al. 2000, eq. 12)."""
    known = robot.spec.suspension
    return BaseTurn(known.model.yaw_per_swing * swings, known.yaw_sigma_mrad / 1e3 * math.sqrt(swings))


def turn_by_gyros(robot: Robot, before: Fixed, now: Fixed | None = None) -> BaseTurn:
    """What the gyros felt from one fixation to another, or until now; the robot has some."""
    assert robot.spec.imu is not None
    yaw, moved = (robot.attitude.yaw, robot.attitude.moved) if now is None else (now.attitude[2], now.moved)
    walk = math.radians(robot.spec.imu.angle_random_walk_deg_rt_s)
    return BaseTurn(yaw - before.attitude[2], yaw_sigma(walk, moved - before.moved))


def fused(before: Fixed, turn: BaseTurn, now: Fixed) -> Fixed:
    """What was found now, with what was found before and the base's turn since then.

    Where the base stands it kept. Both weigh by their variance (a Kalman filter's update of states that are
    measured one by one). Where they are further apart than chance has it, the base was moved meanwhile: what
    was found before is over.
    """
    spread = math.hypot(before.sigma[1], turn.sigma)
    place = (before.sigma[0] ** 2, now.sigma[0] ** 2)
    heading = (spread**2, now.sigma[1] ** 2)
    share, share_of_heading = place[0] / sum(place), heading[0] / sum(heading)
    old = before.pose.compose(Pose2(0.0, 0.0, turn.yaw))
    moved = old.distance(now.pose) > GATE * math.sqrt(sum(place))
    if moved or old.turn(now.pose) > GATE * math.sqrt(sum(heading)):
        return now
    pose = Pose2(
        old.x + share * (now.pose.x - old.x),
        old.y + share * (now.pose.y - old.y),
        old.theta + share_of_heading * wrap(now.pose.theta - old.theta),
    )
    sigma = (math.sqrt(place[0] * place[1] / sum(place)), math.sqrt(heading[0] * heading[1] / sum(heading)))
    return now._replace(pose=pose, sigma=sigma)
