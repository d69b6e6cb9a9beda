"""Following a route with a base that drives in any direction."""

from __future__ import annotations

import math

import numpy as np
from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.drive_limits import DriveLimits, Ramp
from handcart.robotics.navigation.following.path_tracking import MIN_SPEED_M_S, PathTracker
from handcart.robotics.navigation.following.pose_regulator import PoseRegulator, PoseTolerance
from handcart.robotics.navigation.maps.speed_limits import AllowedSpeeds
from handcart.robotics.numerics.arrays import FloatArray

from .sideways_motion import SidewaysRamp, SidewaysRegulator, speed_towards, turn_to

GOAL_HEADING_DISTANCE_M = 1.0  # before the end, from where the base turns to the goal's heading
SIDEWAYS_GAIN_PER_S = 2.0  # with which an error beside the route dies down
MAX_SIDEWAYS_RATIO = 0.5  # of the planned speed, with which the base returns to the route
MIN_SIDEWAYS_SPEED_M_S = 0.05
MIN_TURNING_RATIO = 0.3  # of the planned speed, while the base heads elsewhere


class SidewaysTracker(PathTracker):
    """Controller that drives a base that can drive sideways along a route to its end.

    The base's heading is that of the route, and in the last metre that of the goal.

    Unlike a base with differential drive, it need not turn in place first, because it can turn while it
    drives.
    """

    _ramp: SidewaysRamp

    def __init__(
        self,
        points: FloatArray,
        goal_heading: float | None,
        limits: DriveLimits,
        reverse: bool = False,
        tolerance: PoseTolerance = PoseTolerance(),
        allowed: AllowedSpeeds | None = None,
    ) -> None:
        """Track a route.

        Args:
            points: (n, 2) from near the robot to the goal, on the map, in [m].
            goal_heading: heading at the end, in [rad]; None: any.
            limits: limits of the base.
            reverse: True to drive backwards: the rear leads.
            tolerance: tolerance of the arrival.
            allowed: speed limits by position; None: those of the drive.
        """
        self._goal_heading = goal_heading
        super().__init__(points, goal_heading, limits, reverse, tolerance, allowed)

    @override
    def _make_ramp(self, limits: DriveLimits) -> Ramp:
        return SidewaysRamp(limits)

    @override
    def _make_regulator(self, goal: Pose2, tolerance: PoseTolerance, any_heading: bool) -> PoseRegulator:
        return SidewaysRegulator(goal, self._limits, tolerance, any_heading, self._ramp)

    @property
    @override
    def _profile_limits(self) -> DriveLimits:
        return self._limits._replace(turn_rate=math.inf)

    @override
    def command(self, pose: Pose2, dt: float, most: float = math.inf) -> tuple[float, ...]:
        self._advance(pose)
        self._closing = self._closing or self._is_at_end(dt)
        if self._closing:
            return self._regulator.command(pose, dt)
        reference = self._reference()
        is_last = self.remaining < GOAL_HEADING_DISTANCE_M and self._goal_heading is not None
        heading = self._goal_heading if is_last else wrap(reference.theta + self._flip)
        assert heading is not None
        x, y = self._velocity(reference, pose, wrap(heading - pose.theta), most)
        return self._ramp.towards(x, turn_to(heading, pose, self._limits), dt, y)

    def _velocity(self, reference: Pose2, pose: Pose2, off: float, most: float) -> tuple[float, float]:
        """Return the wanted speeds ahead and to the left, in [m/s].

        `off` is the wanted less the actual heading, in [rad].
        """
        planned = min(most, float(np.interp(self._progress, self._along, self._speed)))
        planned *= max(MIN_TURNING_RATIO, math.cos(0.5 * off) ** 2)
        beside = reference.inverse().apply(np.array([[pose.x, pose.y]]))[0, 1]
        aside = max(MAX_SIDEWAYS_RATIO * planned, MIN_SIDEWAYS_SPEED_M_S)
        back = max(-aside, min(aside, -SIDEWAYS_GAIN_PER_S * float(beside)))
        size = max(planned, MIN_SPEED_M_S)
        towards = reference.theta + math.atan2(back, size) - pose.theta
        x, y = math.cos(towards), math.sin(towards)
        size = min(math.hypot(size, back), speed_towards(x, y, self._limits))
        return size * x, size * y


def make_tracker(
    points: FloatArray,
    goal_heading: float | None,
    limits: DriveLimits,
    reverse: bool = False,
    tolerance: PoseTolerance = PoseTolerance(),
    allowed: AllowedSpeeds | None = None,
) -> PathTracker:
    """Return a tracker for a route: a `SidewaysTracker` if the limits allow driving sideways, else a
    `PathTracker`.

    Args:
        points: (n, 2) points of the route, on the map, in [m].
        goal_heading: heading at the end, in [rad]; None: any.
        limits: limits of the drive.
        reverse: True to drive backwards.
        tolerance: tolerance of the goal.
        allowed: largest speeds along the path; None: those of the drive.
    """
    kind = SidewaysTracker if limits.sideways > 0.0 else PathTracker
    return kind(points, goal_heading, limits, reverse, tolerance, allowed)


def make_regulator(goal: Pose2, limits: DriveLimits, tolerance: PoseTolerance) -> PoseRegulator:
    """Return a regulator for a goal pose: for a base that drives sideways if the limits allow that, otherwise
    for a differential drive.
    """
    kind = SidewaysRegulator if limits.sideways > 0.0 else PoseRegulator
    return kind(goal, limits, tolerance)
