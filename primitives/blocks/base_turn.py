"""Yaw of the base since a fixation, and its standard deviation."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Fixed
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.attitude import yaw_sigma

FUSION_GATE_SIGMAS = 5.0  # sigmas


class BaseTurn(NamedTuple):
    """Yaw of the base since its pose was last measured at a landmark, positive to the left, and sigma of the
    yaw, in [rad].
    """

    yaw: float
    sigma: float


def turn_by_model(robot: Robot, swings: int) -> BaseTurn:
    """Return the yaw of the base that the suspension's model predicts (Hatano et al. 2000, eq. 12).

    Args:
        robot: robot whose suspension model is used.
        swings: number of swings: motions of the loaded hand over at least `suspension.swing_from_mm`.
    """
    known = robot.spec.suspension
    return BaseTurn(known.model.yaw_per_swing * swings, known.yaw_sigma_mrad / 1e3 * math.sqrt(swings))


def turn_by_gyros(robot: Robot, before: Fixed, now: Fixed | None = None) -> BaseTurn:
    """Return the yaw that the gyros measured between two fixations (measurements at a landmark).

    Args:
        robot: robot with an IMU, whose gyros are used.
        before: earlier fixation.
        now: later fixation; None: the present time.
    """
    assert robot.spec.imu is not None
    yaw, moved = (robot.attitude.yaw, robot.attitude.moved) if now is None else (now.attitude[2], now.moved)
    walk = math.radians(robot.spec.imu.angle_random_walk_deg_rt_s)
    return BaseTurn(yaw - before.attitude[2], yaw_sigma(walk, moved - before.moved))


def fused(before: Fixed, turn: BaseTurn, now: Fixed) -> Fixed:
    """Return the current fixation (pose of the base measured at a landmark), fused with an earlier one.

    Between both, the base has turned, but not moved. Positions and headings of both fixations are weighted by
    their variances (update of a Kalman filter with states measured one by one). If they differ by more than
    `FUSION_GATE_SIGMAS` standard deviations, the base was moved meanwhile: `now` is returned unchanged.

    Args:
        before: earlier fixation.
        turn: yaw of the base since then.
        now: current fixation.
    """
    spread = math.hypot(before.sigma[1], turn.sigma)
    place = (before.sigma[0] ** 2, now.sigma[0] ** 2)
    heading = (spread**2, now.sigma[1] ** 2)
    share, share_of_heading = place[0] / sum(place), heading[0] / sum(heading)
    old = before.pose.compose(Pose2(0.0, 0.0, turn.yaw))
    moved = old.distance(now.pose) > FUSION_GATE_SIGMAS * math.sqrt(sum(place))
    if moved or old.turn(now.pose) > FUSION_GATE_SIGMAS * math.sqrt(sum(heading)):
        return now
    pose = Pose2(
        old.x + share * (now.pose.x - old.x),
        old.y + share * (now.pose.y - old.y),
        old.theta + share_of_heading * wrap(now.pose.theta - old.theta),
    )
    sigma = (math.sqrt(place[0] * place[1] / sum(place)), math.sqrt(heading[0] * heading[1] / sum(heading)))
    return now._replace(pose=pose, sigma=sigma)
