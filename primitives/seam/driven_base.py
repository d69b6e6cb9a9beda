"""A base that drives along the seam while the arm has the tool on it."""

from __future__ import annotations

import math

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.seam import seam_causes
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.alongside import level_with
from handcart.robotics.manipulation.tracking.tool_follower import ToolFollower
from handcart.robotics.navigation.following.straight_way import StraightWay
from handcart.robotics.numerics.arrays import FloatArray

START_ACCELERATION_SHARE = 0.5  # of the acceleration limit; the rest is for corrections
MOST_BESIDE = 0.06  # [m] from its place


def way_from_here(robot: Robot, place: str, planned: Pose2) -> Pose2:
    """Return the pose from which the base drives straight along a seam, after it stopped near the planned
    pose.

    Args:
        robot: robot at its place, at rest.
        place: name of the place in messages.
        planned: map_T_base of the place.

    Returns:
        map_T_base on the straight line through the planned pose, along its heading, at the point nearest to
        the base.

    Raises:
        Discrepancy: the base is too far from the planned pose.
    """
    off = robot.pose.distance(planned)
    if exceeds(off, MOST_BESIDE):
        away = Measured("Base", "off its place", off, MOST_BESIDE, "m")
        raise Discrepancy(
            f"the base isn't at {place}, where its route along the seam begins",
            measured=away,
            cause=causes.OFF_GOAL,
        )
    return planned.compose(Pose2(robot.pose.relative_to(planned).x, 0.0, 0.0))


class DrivenBase:
    """Base that drives along a seam next to the tool, while the arm corrects the base's errors in each
    period.

    When wheels slip, the base deviates from its planned straight line. The localizer measures this deviation
    in each period, and the arm corrects it in the next period: "base feedback" of Shin et al. (2005), section
    4.
    """

    def __init__(
        self, robot: Robot, follower: ToolFollower, tools: ToolPath, start: Pose2, near: FloatArray
    ) -> None:
        """Create a driven base whose tool is before its first point.

        Args:
            robot: its arm holds the tool before the first point.
            follower: inverse kinematics of the arm.
            tools: planned poses of the tool, one point each period.
            start: map_T_base at which the straight way begins.
            near: (n,) joints of the arm at the first point, in [rad] or [m].
        """
        self._robot, self._follower, self._tools = robot, follower, tools
        self.heading = start.theta
        """Heading of the way, in [rad]."""
        self._spots = level_with(start, tools.points)[:, :2]
        self._along = (self._spots - start[:2]) @ (math.cos(start.theta), math.sin(start.theta))
        self._way = StraightWay(start, robot.drive_limits)
        self._joints = near

    def ahead(self, index: int) -> FloatArray:
        """Return the points (k, 2) of the base's route that are left to drive, on the map, in [m].

        Args:
            index: number of the point of the tool's path at which the tool is now.
        """
        return self._spots[max(0, index - 1) :]

    def joints(self, index: int) -> FloatArray:
        """Command the base for the next period; return the arm's joints (n,) for the period's end, in [rad]
        or [m].

        Args:
            index: number of the tool's point at the end of the period.

        Raises:
            Discrepancy: an obstacle is in the base's way, or the arm does not reach the seam any more.
        """
        robot, dt = self._robot, self._robot.period
        if robot.held is not None:
            raise Discrepancy(
                f"the base is held back beside the seam: {robot.held.words}", cause=causes.BLOCKED
            )
        before = self._along[max(0, index - 1)]
        speed, turn_rate = self._way.command(robot.pose, before, (self._along[index] - before) / dt, dt)
        robot.base.drive(speed, turn_rate)
        base = self.base_at_end(index, speed, turn_rate)
        try:
            found = self._follower.joints(self._tools.part(index, index), base.lift(), self._joints)
        except Untrackable as error:
            raise Discrepancy(
                f"the seam {error.why} from where the base has come to", cause=seam_causes.UNTRACKABLE
            ) from None
        self._joints = found[0]
        return self._joints

    def base_at_end(self, index: int, speed: float, turn_rate: float) -> Pose2:
        """Return map_T_base after the next period, predicted from the present pose.

        Args:
            index: number of the tool's point at the end of the period.
            speed: commanded speed, in [m/s].
            turn_rate: commanded turn rate, in [rad/s].
        """
        dt = self._robot.period
        halfway = Pose2(0.0, 0.0, 0.5 * turn_rate * dt)
        return self._robot.pose.compose(halfway).compose(Pose2(speed * dt, 0.0, 0.0)).compose(halfway)
