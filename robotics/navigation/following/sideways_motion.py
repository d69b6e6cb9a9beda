"""Commands of a base that drives in any direction, and its way to a pose."""

from __future__ import annotations

import math

from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.drive_limits import DriveLimits, Ramp, rate_to_stop
from handcart.robotics.navigation.following.pose_regulator import FINE_SHARE, PoseRegulator, PoseTolerance


class SidewaysRamp(Ramp):
    """Limiter of speed and acceleration for the commands of a base that can drive in any direction.

    The change of the velocity is limited as a vector on the floor, so a base that turns while it drives
    straight has no acceleration. The largest velocities in all directions form an ellipse in the base frame.
    """

    def __init__(self, limits: DriveLimits, sideways: float = 0.0) -> None:
        """Start at rest, or with a speed to the left in [m/s]."""
        super().__init__(limits)
        self.sideways = sideways

    @property
    @override
    def at_rest(self) -> bool:
        return super().at_rest and abs(self.sideways) < 1e-3

    @override
    def reset(self) -> None:
        super().reset()
        self.sideways = 0.0

    @override
    def towards(self, speed: float, turn_rate: float, dt: float, sideways: float = 0.0) -> tuple[float, ...]:
        limits = self.limits
        last, turned = complex(self.speed, self.sideways), complex(0.0, -self.turn_rate * dt)
        last *= complex(math.cos(turned.imag), math.sin(turned.imag))
        change = complex(*_within_ellipse(speed, sideways, limits)) - last
        most = limits.acceleration * dt
        now = last + change * min(1.0, most / max(abs(change), 1e-12))
        self.speed, self.sideways = _within_ellipse(now.real, now.imag, limits)
        faster = max(-limits.turn_rate, min(limits.turn_rate, turn_rate)) - self.turn_rate
        most = limits.turn_acceleration * dt
        self.turn_rate += max(-most, min(most, faster))
        return self.speed, self.turn_rate, self.sideways


class SidewaysRegulator(PoseRegulator):
    """Regulator that brings a base that can drive sideways to a pose, by a straight drive during which it
    turns.
    """

    _ramp: SidewaysRamp

    def __init__(
        self,
        goal: Pose2,
        limits: DriveLimits,
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
            ramp: `SidewaysRamp` with the commands so far; None: at rest.
        """
        super().__init__(goal, limits, tolerance, any_heading, SidewaysRamp(limits) if ramp is None else ramp)

    @override
    def command(self, pose: Pose2, dt: float) -> tuple[float, ...]:
        goal, limits = self.goal.relative_to(pose), self._ramp.limits
        away = math.hypot(goal.x, goal.y)
        near = away < FINE_SHARE * self.tolerance.position
        most = speed_towards(goal.x, goal.y, limits)
        along = 0.0 if near else rate_to_stop(away, most, limits.acceleration) / away
        is_fine = self._any_heading or abs(goal.theta) < FINE_SHARE * self.tolerance.heading
        turn = 0.0 if is_fine else rate_to_stop(goal.theta, limits.turn_rate, limits.turn_acceleration)
        return self._ramp.towards(along * goal.x, turn, dt, along * goal.y)


def speed_towards(x: float, y: float, limits: DriveLimits) -> float:
    """Return the maximum speed, in [m/s], at which a base may drive along a direction in the base frame.

    Args:
        x: component ahead of a vector along the direction, of any length.
        y: component to the left of this vector.
        limits: limits of the base.
    """
    size = math.hypot(x / limits.speed, y / limits.sideways)
    return limits.speed if size == 0.0 else math.hypot(x, y) / size


def turn_to(heading: float, pose: Pose2, limits: DriveLimits) -> float:
    """Return the turn rate, in [rad/s], with which a base turns to a heading and stops there.

    Args:
        heading: wanted heading in the frame of `pose`, in [rad].
        pose: pose of the base now.
        limits: limits of the base.
    """
    return rate_to_stop(wrap(heading - pose.theta), limits.turn_rate, limits.turn_acceleration)


def _within_ellipse(speed: float, sideways: float, limits: DriveLimits) -> tuple[float, float]:
    size = max(1.0, math.hypot(speed / limits.speed, sideways / limits.sideways))
    return speed / size, sideways / size
