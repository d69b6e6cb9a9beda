"""The last centimetres: bringing a differential drive to a pose."""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.drive_limits import DriveLimits, Ramp, rate_to_stop

MIN_STEERED_DISTANCE_M = 0.1  # [m]: nearer than this the bearing to the goal is noise; the heading is held

FINE_SHARE = 0.25  # of the tolerance of the heading, within which noise of the pose is not followed


class PoseTolerance(NamedTuple):
    """Tolerances of position and heading within which a base counts as arrived at a goal pose."""

    position: float = 0.008
    """Position tolerance in [m]."""
    heading: float = 0.005
    """Heading tolerance in [rad]."""


class _Phase(Enum):
    AIM = "turn towards the goal, or away from it"
    DRIVE = "straight to it"
    ALIGN = "turn to the goal's heading"


class PoseRegulator:
    """Regulator that brings a base with differential drive to a nearby pose; it turns, drives, and turns
    again.

    A differential drive can't move sideways. So the base first turns its front or its back to the goal,
    whichever is less, then drives there, and then turns to the goal's heading. Each of the three steps is a
    stable one-dimensional control loop. If the position is off after the last turn, the steps are repeated.

    When the distance is only millimetres, direction and length of the drive are measured before the first
    turn and then kept. Otherwise a base that shifts as it turns would follow a direction to the goal that
    changes all the time. The shifts of the first and the last turn cancel.
    """

    def __init__(
        self,
        goal: Pose2,
        limits: DriveLimits = DriveLimits(),
        tolerance: PoseTolerance = PoseTolerance(),
        any_heading: bool = False,
        ramp: Ramp | None = None,
    ) -> None:
        """Regulate to a goal.

        Args:
            goal: map_T_base to reach.
            limits: limits of the base.
            tolerance: tolerance of the arrival.
            any_heading: the heading at the goal doesn't matter.
            ramp: the commands so far, when this takes over from another law.
        """
        self.goal = goal
        self.tolerance = tolerance
        self._any_heading = any_heading
        self._ramp = Ramp(limits) if ramp is None else ramp
        self._phase = _Phase.ALIGN
        self._backwards = False
        self._heading: float | None = None
        self._ahead = 0.0
        self._stop = goal

    def finished(self, pose: Pose2) -> bool:
        """Return True if the robot is at rest at the goal pose, within the tolerances of position and
        heading.
        """
        return (
            self._ramp.at_rest and self._aligned(pose) and pose.distance(self.goal) <= self.tolerance.position
        )

    def stopped(self) -> None:
        """Set the last command to zero, because another controller has stopped the base in the meantime."""
        self._ramp.reset()

    def _aligned(self, pose: Pose2) -> bool:
        return self._any_heading or pose.turn(self.goal) <= self.tolerance.heading

    def command(self, pose: Pose2, dt: float) -> tuple[float, ...]:
        """Return the command for the next period: speed in [m/s], negative backwards, and turn rate in
        [rad/s], positive to the left.

        Args:
            pose: map_T_base.
            dt: control period, in [s].
        """
        goal = self.goal.relative_to(pose)
        self._choose_phase(pose, goal)
        limits = self._ramp.limits
        if self._phase is _Phase.ALIGN:
            fine = self._any_heading or abs(goal.theta) < FINE_SHARE * self.tolerance.heading
            turn = 0.0 if fine else goal.theta
            return self._ramp.towards(0.0, self._turn_rate(turn), dt)
        if self._phase is _Phase.AIM:
            return self._ramp.towards(0.0, self._turn_rate(self._aim(pose, goal)), dt)
        far = math.hypot(goal.x, goal.y) > MIN_STEERED_DISTANCE_M
        turn_rate = self._turn_rate(self._bearing(goal)) if far else 0.0
        rest = self._stop.relative_to(pose).x
        return self._ramp.towards(rate_to_stop(rest, limits.speed, limits.acceleration), turn_rate, dt)

    def _choose_phase(self, pose: Pose2, goal: Pose2) -> None:
        distance = pose.distance(
            self.goal
        )  # as in `finished`: rounded otherwise, both could wait for the other
        if self._phase is _Phase.ALIGN:
            aligned = self._aligned(pose)
            far = distance > max(5.0 * self.tolerance.position, MIN_STEERED_DISTANCE_M)
            if distance > self.tolerance.position and (far or (aligned and self._ramp.at_rest)):
                self._phase, self._backwards = _Phase.AIM, goal.x < 0.0
                self._heading = None if far else wrap(pose.theta + self._bearing(goal))
                self._ahead = math.copysign(distance, goal.x)
        elif self._phase is _Phase.AIM:
            fine = 0.25 * self.tolerance.position / max(distance, self.tolerance.position)
            if abs(self._aim(pose, goal)) < max(fine, 0.01) and abs(self._ramp.turn_rate) < 0.05:
                self._phase = _Phase.DRIVE
                straight = pose.compose(Pose2(self._ahead, 0.0, 0.0))
                self._stop = self.goal if self._heading is None else straight
        else:
            rest = self._stop.relative_to(pose).x
            if abs(rest) < 0.2 * self.tolerance.position and abs(self._ramp.speed) < 0.02:
                self._phase = _Phase.ALIGN

    def _aim(self, pose: Pose2, goal: Pose2) -> float:
        """Return the turn that is left before the base drives, in [rad], positive to the left."""
        return self._bearing(goal) if self._heading is None else wrap(self._heading - pose.theta)

    def _bearing(self, goal: Pose2) -> float:
        """Return the turn that points the front, or the back, at the goal, in [rad]."""
        bearing = math.atan2(goal.y, goal.x)
        return wrap(bearing + math.pi) if self._backwards else bearing

    def _turn_rate(self, turn: float) -> float:
        limits = self._ramp.limits
        return rate_to_stop(turn, limits.turn_rate, limits.turn_acceleration)
