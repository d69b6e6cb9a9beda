"""Following a route: the tracking law of Kanayama et al. (1990) for a differential drive."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.drive_limits import DriveLimits, Ramp, rate_to_stop
from handcart.robotics.navigation.following.pose_regulator import PoseRegulator, PoseTolerance
from handcart.robotics.navigation.maps.speed_limits import AllowedSpeeds
from handcart.robotics.numerics.arrays import FloatArray

HEADING_GAIN = 10.0  # [1/m], Kθ; with a sideways gain Ky = Kθ²/4 critically damped, 0.2 m to die down
HEADING_RATE = 6.0  # [1/s] at most with which a heading error dies down: a period and the drives lag behind
APPROACH_ANGLE_RAD = 0.3  # at most, at which the robot returns to the route; more would lead across it
CORNER_PER_M = 8.0  # [1/m] of curvature; a sharper bend is a corner, at which the base turns in place
TURN_SHARE = 0.6  # of the turn rate that curves are planned with; the rest is for corrections
LATERAL_SHARE = 0.8  # likewise of the lateral acceleration
PROFILE_BRAKING_SHARE = 0.7  # of the acceleration that a route's speeds are planned with
TURN_FROM, TURN_UNTIL = 0.7, 0.08  # [rad] of heading error that is turned away in place
POINT_SPACING_M = 0.04  # [m] between reference points
TANGENT_POINTS = 2  # reference points on each side that define a tangent
MIN_SPEED_M_S = 0.04  # [m/s]
ZONE_MARGIN_POINTS = 3  # reference points before and behind a zone in which its limit holds
SEARCH_AHEAD_M = 0.6  # [m] of route ahead in which the nearest point is looked for
CLOSING_DISTANCE_M = 0.015  # [m] left, within which the goal's pose itself is regulated
STOP_DISTANCE_M = 0.002  # [m] left, or what braking takes if that is more: nothing more is gained by driving
MAX_CLOSING_PERIODS = 12  # within `CLOSING_DISTANCE_M`: a base that is held there gets no nearer


class PathTracker:
    """Controller that drives a base along a route to its end, and turns it to the goal's heading there.

    Errors are measured at the point of the route that is nearest to the robot, but never behind an earlier
    such point. This point does not move with time, so a robot that is slow, held or pushed does not fall
    behind it. The base turns in place where its heading is far off the route's, and slows down in curves and
    before the end. A `PoseRegulator` drives the last centimetre and the final turn.
    """

    def __init__(
        self,
        points: FloatArray,
        goal_heading: float | None = None,
        limits: DriveLimits = DriveLimits(),
        reverse: bool = False,
        tolerance: PoseTolerance = PoseTolerance(),
        allowed: AllowedSpeeds | None = None,
    ) -> None:
        """Track a route.

        Args:
            points: (n, 2) from near the robot to the goal, on the map, in [m].
            goal_heading: heading at the end, in [rad]; any if None.
            limits: limits of the base.
            reverse: drive backwards: the rear leads.
            tolerance: tolerance of the arrival.
            allowed: speed limits by position; None: those of the drive.
        """
        self._limits = limits
        self._flip = math.pi if reverse else 0.0
        self._ramp = self._make_ramp(limits)
        self._turning = True
        self._closing = False
        self._set_route(points, allowed)
        end = self._points[-1]
        goal = Pose2(float(end[0]), float(end[1]), 0.0 if goal_heading is None else wrap(goal_heading))
        self._regulator = self._make_regulator(goal, tolerance, goal_heading is None)

    def _make_ramp(self, limits: DriveLimits) -> Ramp:
        return Ramp(limits)

    def _make_regulator(self, goal: Pose2, tolerance: PoseTolerance, any_heading: bool) -> PoseRegulator:
        return PoseRegulator(goal, self._limits, tolerance, any_heading, self._ramp)

    def reroute(self, points: FloatArray, allowed: AllowedSpeeds | None = None) -> None:
        """Continue along another route to the same goal, without a stop; `progress` begins again at 0.

        Args:
            points: (n, 2) points from near the robot to the goal, on the map, in [m].
            allowed: speed limits by position; None: those of the drive.
        """
        self._set_route(points, allowed)

    def limit_speeds(self, allowed: AllowedSpeeds | None) -> None:
        """Follow the same route with new speed limits by position; None: only the drive's own limits."""
        most = np.full(len(self._points), self._limits.speed)
        if allowed is not None:
            most = _around(allowed.at(self._points, self._limits.speed))
        self._speed = _speed_profile(self._along, self._curvature, self._profile_limits, most)

    @property
    def _profile_limits(self) -> DriveLimits:
        """Limits that the speeds along the route are planned with."""
        return self._limits

    def _set_route(self, points: FloatArray, allowed: AllowedSpeeds | None) -> None:
        self._points, self._along = _resample(points)
        self._heading = _tangents(self._points)
        self._curvature = _curvatures(self._heading, self._along)
        self.limit_speeds(allowed)
        self._progress, self._near_periods = 0.0, 0
        self._closing = len(self._points) < 2

    def stopped(self) -> None:
        """Set the last command to zero, because another controller has driven the base in the meantime."""
        self._ramp.reset()
        self._turning = True

    @property
    def reverse(self) -> bool:
        """True if the robot follows the route backwards."""
        return self._flip != 0.0

    @property
    def closing(self) -> bool:
        """True if the end of the route is reached and only position and heading are still corrected there."""
        return self._closing

    def _is_at_end(self, dt: float) -> bool:
        """Return whether the rest is within the braking distance, or lasts too long; call it once a period.

        `dt` is the control period in [s].
        """
        if self.remaining >= CLOSING_DISTANCE_M:
            self._near_periods = 0
            return False
        self._near_periods += 1
        speed = abs(self._ramp.speed)
        stop = speed * (speed / (2.0 * self._limits.acceleration) - 0.5 * dt)  # it brakes in this period
        return self.remaining < max(STOP_DISTANCE_M, stop) or self._near_periods > MAX_CLOSING_PERIODS

    @property
    def progress(self) -> float:
        """Distance that the robot has covered along the route, in [m]."""
        return self._progress

    @property
    def remaining(self) -> float:
        """Length of the route from the robot's present place on it to its end, in [m]."""
        return float(self._along[-1]) - self._progress

    @property
    def ahead(self) -> FloatArray:
        """Points (k, 2) of the remaining route, from the robot's present place on it, on the map in [m]."""
        here = [np.interp(self._progress, self._along, self._points[:, i]) for i in (0, 1)]
        return np.vstack([here, self._points[self._along > self._progress]])

    def finished(self, pose: Pose2) -> bool:
        """Return True if the robot is at rest at the end of the route, within the goal's tolerances."""
        return self._closing and self._regulator.finished(pose)

    def command(self, pose: Pose2, dt: float, most: float = math.inf) -> tuple[float, ...]:
        """Return the command of the base for the next period.

        The command is the speed in [m/s], negative backwards, and the turn rate in [rad/s], positive to the
        left. For a base that can drive sideways, the speed to the left in [m/s] follows.

        Args:
            pose: map_T_base.
            dt: control period, in [s].
            most: limit of the speed along the route, in [m/s].
        """
        self._advance(pose)
        self._closing = self._closing or self._is_at_end(dt)
        if self._closing:
            return self._regulator.command(pose, dt)
        speed, turn_rate = self._track(Pose2(pose.x, pose.y, wrap(pose.theta + self._flip)), most)
        return self._ramp.towards(-speed if self._flip else speed, turn_rate, dt)

    def hold(self, pose: Pose2, dt: float) -> tuple[float, ...]:
        """Return the command to come to rest and stay at rest.

        The values are the speed in [m/s], negative backwards, the turn rate in [rad/s], positive to the left,
        and for a base that can drive sideways, the speed to the left in [m/s].

        While the base still rolls, its progress along the route is updated.

        Args:
            pose: map_T_base.
            dt: the control period, in [s].
        """
        self._advance(pose)
        return self._ramp.towards(0.0, 0.0, dt)

    def _advance(self, pose: Pose2) -> None:
        """Move progress to the nearest point of the route not far ahead; never back."""
        low = int(np.searchsorted(self._along, self._progress, side="right")) - 1
        high = int(np.searchsorted(self._along, self._progress + SEARCH_AHEAD_M, side="right")) + 1
        starts, ends = self._points[low : high - 1], self._points[low + 1 : high]
        if len(ends) == 0:
            return
        starts = starts[: len(ends)]
        rays = ends - starts
        lengths = np.maximum(np.hypot(*rays.T), 1e-12)
        at = np.clip(((np.array(pose[:2]) - starts) * rays).sum(axis=1) / lengths**2, 0.0, 1.0)
        away = np.hypot(*(starts + at[:, None] * rays - pose[:2]).T)
        best = int(np.argmin(away))
        self._progress = max(self._progress, float(self._along[low + best] + at[best] * lengths[best]))

    def _track(self, pose: Pose2, most: float) -> tuple[float, float]:
        """Wanted speed along the route and turn rate."""
        reference = self._reference()
        off = reference.relative_to(pose)
        if abs(off.theta) > TURN_FROM or (self._turning and abs(off.theta) > TURN_UNTIL):
            self._turning = True
            return 0.0, rate_to_stop(off.theta, self._limits.turn_rate, self._limits.turn_acceleration)
        self._turning = False
        planned = min(most, float(np.interp(self._progress, self._along, self._speed)))
        speed = planned * math.cos(
            off.theta
        )  # Kanayama (1990), eq. 12, with x_e = 0 by the choice of reference
        gain = min(HEADING_GAIN, HEADING_RATE / max(planned, abs(self._ramp.speed), MIN_SPEED_M_S))
        approach = max(-APPROACH_ANGLE_RAD, min(APPROACH_ANGLE_RAD, 0.25 * gain * off.y))
        bend = float(np.interp(self._progress, self._along, self._curvature))
        return speed, planned * (bend + gain * (approach + math.sin(off.theta)))

    def _reference(self) -> Pose2:
        x, y, heading = (
            float(np.interp(self._progress, self._along, values))
            for values in (self._points[:, 0], self._points[:, 1], self._heading)
        )
        return Pose2(x, y, wrap(heading))


def _resample(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the route evenly spaced (n, 2), and the length along it (n,)."""
    points = np.asarray(points, dtype=np.float64)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    total = float(along[-1])
    if total < 1e-6:
        return points[-1:], np.zeros(1)
    at = np.linspace(0.0, total, max(2, math.ceil(total / POINT_SPACING_M) + 1))
    points = np.column_stack([np.interp(at, along, points[:, i]) for i in (0, 1)])
    return points, np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def _tangents(points: FloatArray) -> FloatArray:
    """Headings (n,) in travel direction, in [rad], without jumps of a whole turn."""
    if len(points) < 2:
        return np.zeros(len(points))
    index = np.arange(len(points))
    before, after = np.maximum(index - TANGENT_POINTS, 0), np.minimum(index + TANGENT_POINTS, len(points) - 1)
    rays = points[after] - points[before]
    headings: FloatArray = np.unwrap(np.arctan2(rays[:, 1], rays[:, 0]))
    return headings


def _curvatures(heading: FloatArray, along: FloatArray) -> FloatArray:
    if len(along) < 2:
        return np.zeros(len(along))
    return np.clip(np.gradient(heading, along), -CORNER_PER_M, CORNER_PER_M)


def _around(most: FloatArray) -> FloatArray:
    """Return the least limit (n,) of each point and its neighbours: the robot is never exactly at a point."""
    if len(most) < 2 * ZONE_MARGIN_POINTS + 1:
        return np.full(len(most), most.min())
    padded = np.pad(most, ZONE_MARGIN_POINTS, mode="edge")
    least: FloatArray = np.lib.stride_tricks.sliding_window_view(padded, 2 * ZONE_MARGIN_POINTS + 1).min(
        axis=1
    )
    return least


def _speed_profile(
    along: FloatArray, curvature: FloatArray, limits: DriveLimits, most: FloatArray
) -> FloatArray:
    """Speeds (n,) in [m/s] up to `most` (n,) that curves allow and from which one can brake in time."""
    bend = np.maximum(np.abs(curvature), 1e-6)
    speed = np.minimum(most, TURN_SHARE * limits.turn_rate / bend)
    speed = np.minimum(speed, np.sqrt(LATERAL_SHARE * limits.lateral_acceleration / bend))
    speed[-1] = 0.0
    speeds, rooms = speed.tolist(), np.diff(along).tolist()  # single elements of arrays are slow to read
    braking = 2.0 * PROFILE_BRAKING_SHARE * limits.acceleration
    for i in range(len(speeds) - 2, -1, -1):
        speeds[i] = min(speeds[i], math.sqrt(speeds[i + 1] ** 2 + braking * rooms[i]))
    return np.asarray(np.maximum(speeds, MIN_SPEED_M_S))
