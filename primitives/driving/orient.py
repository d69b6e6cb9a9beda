"""ORIENT: drive ahead until the heading of the robot is known."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured

from .lidar_watch import LidarWatch

BLOCKED_TIMEOUT_S = 10.0  # time for which an obstacle may prevent the turn
GETTING_ON_M = 0.1  # less is not progress
STANDING_TIMEOUT_S = 60.0  # without progress, whatever stops the base again and again
STOPPING_SPEED_M_S = 0.05  # below which the base is let stop


class Orient(ActionPrimitive):
    """Drive straight ahead until position fixes, such as GPS, determine an unknown heading.

    Nothing moves if the heading is known. The lidar keeps the base off obstacles. After a Fail the base has
    driven back along its route.
    """

    longest_m: Annotated[float, Field(gt=0.0, le=200.0)] = 30.0
    """Maximum distance to drive."""

    needs: ClassVar = (Base,)
    needs_pose: ClassVar = False
    arm_inside: ClassVar = True

    _lidar_watch: LidarWatch = PrivateAttr(default_factory=LidarWatch)

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        driven, speed, since = 0.0, 0.0, robot.time
        got_on, got_on_at = 0.0, robot.time
        limits = robot.drive_limits
        while not robot.localization.heading_known:
            if driven > self.longest_m:
                way = Measured("Gps", "way without knowing the heading", driven, self.longest_m, "m")
                raise Discrepancy(
                    "it doesn't show which way the robot heads", measured=way, cause=causes.UNDETERMINED
                )
            if robot.held is None:
                since = robot.time
            elif robot.time > since + BLOCKED_TIMEOUT_S:
                near = Measured("RangeSensor", "room ahead", robot.held.room, robot.held.needed, "m")
                raise Discrepancy(
                    f"the base can't drive ahead: {robot.held.words}", measured=near, cause=causes.BLOCKED
                )
            if driven > got_on + GETTING_ON_M:
                got_on, got_on_at = driven, robot.time
            elif robot.time > got_on_at + STANDING_TIMEOUT_S:
                stood = Measured(
                    "Base", "time without getting on", robot.time - got_on_at, STANDING_TIMEOUT_S, "s"
                )
                raise Discrepancy("the base doesn't get on", measured=stood, cause=causes.NO_PROGRESS)
            speed = min(limits.speed, speed + limits.acceleration * robot.period)
            robot.base.drive(speed, 0.0)
            yield
            driven += abs(robot.driven[0]) * robot.period
            self.found(path_length_m=round(driven, 3))
        while speed > STOPPING_SPEED_M_S:
            speed -= limits.acceleration * robot.period
            robot.base.drive(speed, 0.0)
            yield

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise `NeedsPerson` if the lidar is covered or repeats its last scan; the base waits until then."""
        self._lidar_watch.watch(robot, None)
