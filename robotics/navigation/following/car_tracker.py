"""Driving a car's path: backwards, forwards, backwards, each as far as the path says."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.pure_pursuit import PurePursuit
from handcart.robotics.navigation.routes.tangent_path import PATH_SPACING_M, CarPath
from handcart.robotics.numerics.arrays import FloatArray

BACKING_SPEED_M_S = 0.25  # [m/s]
STANDSTILL_SPEED_M_S = 1e-3  # [m/s]


class _Leg:
    """A piece of the path that is driven in one direction."""

    def __init__(self, poses: FloatArray, reverse: bool, sharpest: float, limits: DriveLimits) -> None:
        turned = poses + np.array([0.0, 0.0, math.pi if reverse else 0.0])
        speed = min(BACKING_SPEED_M_S, limits.speed) if reverse else limits.speed
        self.reverse = reverse
        self.points = poses[:, :2]
        steps = np.hypot(*np.diff(self.points, axis=0).T)
        self.length = float(steps.sum())
        self.pursuit = PurePursuit(turned, sharpest=sharpest, speed=speed, acceleration=limits.acceleration)

    def seen(self, pose: Pose2) -> Pose2:
        """Return the car as the pursuit sees it: backwards, its rear is in front."""
        return Pose2(pose.x, pose.y, wrap(pose.theta + math.pi)) if self.reverse else pose


class CarTracker:
    """Controller that drives a car with front steering along a path to its end, by pure pursuit.

    An error at the end of the path is not corrected, because a car can't move sideways.
    """

    def __init__(self, legs: list[tuple[FloatArray, bool]], sharpest: float, limits: DriveLimits) -> None:
        """Follow some legs.

        Args:
            legs: map_T_base (n, 3) in [m, m, rad] along each leg, and whether it is driven backwards.
            sharpest: curvature that can be steered, in [1/m].
            limits: of the base.
        """
        self._legs = [_Leg(poses, reverse, sharpest, limits) for poses, reverse in legs if len(poses) > 1]
        self._limits = limits
        self._at, self._speed, self._bend = 0, 0.0, 0.0

    @classmethod
    def along(
        cls, path: CarPath, start: Pose2, goal: Pose2, sharpest: float, limits: DriveLimits
    ) -> CarTracker:
        """Return a tracker of a planned path.

        Args:
            path: path, with the distances to drive backwards before and after it.
            start: map_T_base where the path was planned from.
            goal: map_T_base at its end.
            sharpest: largest curvature that can be steered, in [1/m].
            limits: limits of the base's speed, turn rate and accelerations.
        """
        first = np.array([start.compose(Pose2(-path.back_before, 0.0, 0.0))])
        legs = [
            (_straight(start, -path.back_before), True),
            (np.vstack([first, path.poses]), False),
            (_straight(goal.compose(Pose2(path.back_after, 0.0, 0.0)), -path.back_after), True),
        ]
        return cls(legs, sharpest, limits)

    @property
    def remaining(self) -> float:
        """Length of the path from the car's present place on it to its end, in [m]."""
        if self._at >= len(self._legs):
            return 0.0
        return self._legs[self._at].pursuit.left + sum(leg.length for leg in self._legs[self._at + 1 :])

    @property
    def progress(self) -> float:
        """Distance that the car has covered along the path, in [m]."""
        return sum(leg.length for leg in self._legs) - self.remaining

    @property
    def ahead(self) -> FloatArray:
        """Points (k, 2) on the map, in [m], from the car to the end of the path's present leg.

        A leg is a part of the path that is driven in one direction, forwards or backwards.
        """
        if self._at >= len(self._legs):
            return np.empty((0, 2))
        leg = self._legs[self._at]
        left = round(leg.pursuit.left / max(leg.length, 1e-9) * (len(leg.points) - 1))
        return leg.points[len(leg.points) - 1 - left :]

    def finished(self, pose: Pose2) -> bool:
        """Return True if the car is at rest at the end of its path."""
        return self._at >= len(self._legs)

    def command(self, pose: Pose2, dt: float) -> tuple[float, float]:
        """Return the speed to command in [m/s], negative backwards, and the turn rate in [rad/s], positive to
        the left.

        Args:
            pose: map_T_base.
            dt: control period, in [s].
        """
        if self._at >= len(self._legs):
            return 0.0, 0.0
        leg = self._legs[self._at]
        speed, bend = leg.pursuit.command(leg.seen(pose), self._speed, dt)
        if speed <= STANDSTILL_SPEED_M_S:
            self._at, self._speed = self._at + 1, 0.0
            return 0.0, 0.0
        self._speed = max(speed, self._speed - self._limits.acceleration * dt)
        self._bend = bend
        return self._drive(leg)

    def stopped(self) -> None:
        """Set the last speed to zero, because another controller has stopped the car in the meantime."""
        self._speed = 0.0

    def hold(self, pose: Pose2, dt: float) -> tuple[float, float]:
        """Return the speed in [m/s] and turn rate in [rad/s] to command so that the car comes to rest and
        stays at rest.

        While the car still rolls, its progress along the path is updated.

        Args:
            pose: map_T_base.
            dt: control period, in [s].
        """
        if self._at < len(self._legs):
            leg = self._legs[self._at]
            leg.pursuit.advance(leg.seen(pose))
        self._speed = max(0.0, self._speed - self._limits.acceleration * dt)
        return self._drive(self._legs[self._at]) if self._at < len(self._legs) else (0.0, 0.0)

    def _drive(self, leg: _Leg) -> tuple[float, float]:
        most = self._limits.turn_rate
        turn = max(-most, min(most, self._speed * self._bend))
        return (-self._speed if leg.reverse else self._speed), turn


def _straight(start: Pose2, way: float) -> FloatArray:
    """Return (n, 3) poses along a straight line; one if it has no length."""
    count = math.ceil(abs(way) / PATH_SPACING_M - 1e-9) + 1
    return np.array([start.compose(Pose2(way * s, 0.0, 0.0)) for s in np.linspace(0.0, 1.0, count)])
