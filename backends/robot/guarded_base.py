"""The wheels, which no command drives into what the map or the scan shows."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np
from typing_extensions import override

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.base import Base, DriveCommand, HolonomicBase, WheelTravel
from handcart.backends.capabilities.range_sensor import Scan
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.footprint_guard import FootprintGuard
from handcart.robotics.navigation.following.way_guard import NO_STANDS, HoldingObstacle, WayGuard
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.navigation.tracking.yielding import safe_share
from handcart.robotics.numerics.arrays import FloatArray

from .unseen_ground import UnseenGround

SIDE_MARGIN_M = 0.008  # [m] beside the footprint that must stay free
POLYGON_MARGIN_SIGMAS = 1.5  # of a range, likewise beside a polygon: a corner is a point, not an arc
SAME_POINT_M = 1e-6  # [m] by which a point may be off, from one frame to another and back
_FAR = np.array([np.inf])
SPEED_RATIOS = (
    1.0,
    0.7,
    0.45,
    0.25,
    0.1,
)  # shares of a speed that are tried, the last one before standing still


class GuardedBase(HolonomicBase):
    """Base that slows each command down so that driving and braking cause no collision.

    It wraps another base, and knows obstacles from the map, the lidar, earlier contacts and tracked people.
    """

    def __init__(
        self,
        base: Base,
        robot: RobotFile,
        grid: GridMap | None,
        pose: Callable[[], Pose2],
        scan: Callable[[], FloatArray],
        unseen: UnseenGround | None = None,
        restart_scan: Callable[[], None] = lambda: None,
        is_located: Callable[[], bool] = lambda: True,
        is_blind: Callable[[], bool] = lambda: False,
    ) -> None:
        """Guard a base.

        Args:
            base: driven base.
            robot: robot file.
            grid: map, if one exists.
            pose: returns map_T_base.
            scan: returns the lidar's current points without the robot itself, (n, 2) in [m], in the base
                frame.
            unseen: ground that the lidar does not see; None without a lidar.
            restart_scan: called when the base starts again, before `scan`: averages begin there.
            is_located: returns whether the pose is on the map; the map is not used while it is not.
            is_blind: returns whether the lidar repeats an old scan; the base comes to rest meanwhile.
        """
        self._restart_scan = restart_scan
        self._base, self._pose, self._scan, self._unseen = base, pose, scan, unseen
        self._radius, self._grid = robot.footprint_radius_m + SIDE_MARGIN_M, grid
        self._shape = robot.footprint_shape
        sigma = 0.0 if robot.range_sensor is None else robot.range_sensor.sigma_mm / 1e3
        self._margin = max(SIDE_MARGIN_M, POLYGON_MARGIN_SIGMAS * sigma)
        self._braking, self._period = robot.drive.acceleration_m_s2, robot.period_s
        self._turn_braking = math.radians(robot.drive.turn_acceleration_deg_s2)
        self._is_car = robot.drive.kind == "ackermann"
        self._starts = True
        self._command = self._last = DriveCommand()
        self._held: HoldingObstacle | None = None
        self._slowed_to, self._slowed_turn = math.inf, False
        self._felt = NO_STANDS
        self._is_located, self._on_map = is_located, True
        self._is_blind, self._blind_speed = is_blind, math.inf
        self._people: People | None = None
        self._share = 1.0
        self.share_for_people = 1.0
        """Share of the commanded speed in the last period that people allowed; 0: the base waited for
        them.
        """

    @cached_property
    def _map_guard(self) -> WayGuard | FootprintGuard:
        if self._shape.is_disc:
            return WayGuard(self._radius, self._grid)
        return FootprintGuard(self._shape, self._margin, self._grid)

    @cached_property
    def _scan_guard(self) -> WayGuard | FootprintGuard:
        if self._shape.is_disc:
            return WayGuard(self._radius)
        return FootprintGuard(self._shape, self._margin)

    @property
    def _guard(self) -> WayGuard | FootprintGuard:
        return self._map_guard if self._on_map else self._scan_guard

    def _change_frame(self) -> None:
        """Set the current pose as the start if the pose on the map has become known or unknown since the last
        command.
        """
        if self._is_located() == self._on_map:
            return
        self._on_map, self._starts = not self._on_map, True
        if self._unseen is not None:
            self._unseen.forget()

    def drive(self, speed: float, turn_rate: float, sideways: float = 0.0) -> None:
        """Command the base's speeds for the next period, lower than given if obstacles are near on its way.

        Args:
            speed: speed ahead, in [m/s].
            turn_rate: turn rate to the left, in [rad/s].
            sideways: speed to the left, in [m/s].

        Raises:
            CommandError: a value is not finite or beyond the limits, or the base cannot drive sideways.
        """
        command = DriveCommand(speed, turn_rate, sideways)
        moves = command.along != 0.0 or (turn_rate != 0.0 and not self._shape.is_disc)
        if all(map(math.isfinite, command)) and moves:
            way = command.direction
            along, turn_rate = self._allowed(*self._caught_up(command.along, turn_rate), way)
            command = DriveCommand.towards(way, *self._seeing(*self._yielding(along, turn_rate, way)))
        elif math.isfinite(turn_rate):
            command = command._replace(turn_rate=self._caught_up_turn(turn_rate))
        if isinstance(self._base, HolonomicBase):
            self._base.drive(*command)
        elif command.sideways == 0.0:
            self._base.drive(command.speed, command.turn_rate)
        else:
            raise CommandError(f"a sideways speed of {sideways} m/s; allowed: 0, because no wheels do that")
        self._command = command

    @override
    def wheel_travel(self) -> WheelTravel:
        return self._base.wheel_travel()

    def starts_here(self) -> None:
        """Make the base's pose at the next command the start of its drive, to which the base may return even
        if obstacles are close.
        """
        self._starts = True

    def may_stand_at(self, pose: Pose2) -> None:
        """Allow the base to come as close to mapped obstacles as it would be at `pose` (map_T_base).

        This holds until the first command to the base after a call of `starts_here`, with which the next
        motion begins.
        """
        self._begin()
        self._guard.may_stand_at(pose)

    def keep_off(self, points: FloatArray) -> None:
        """Set the points at which the base ran into obstacles earlier, and to which it now keeps a distance.

        Args:
            points: (n, 2) on the map, in [m].
        """
        self._felt = points

    def keep_off_people(self, people: People) -> None:
        """Set the people whose predicted paths the base must not enter in this period."""
        self._people = people

    def _yielding(self, speed: float, turn_rate: float, direction: float) -> tuple[float, float]:
        """Return the part of a command that ends before every person's path.

        Args:
            speed: speed in the direction of travel, in [m/s].
            turn_rate: turn rate to the left, in [rad/s].
            direction: direction of travel in the base frame, in [rad], counter-clockwise from straight ahead.

        Returns:
            Speed in [m/s] and turn rate in [rad/s].
        """
        if self._people is None or speed == 0.0:
            return speed, turn_rate
        pose, command = self._pose().compose(Pose2(0.0, 0.0, direction)), (speed, turn_rate)
        last = self._last.speed * math.cos(direction) + self._last.sideways * math.sin(direction)
        last *= math.copysign(1.0, speed)
        share = safe_share(pose, command, self._people, self._radius, self._braking, self._period, last)
        if share < 1.0:
            self._slowed_to, self._share, self._slowed_turn = share * abs(speed), share, True
            turn_rate = self._caught_up_turn(share * turn_rate)
            self._slowed_turn = True  # of the commanded one, which the next period catches up with
        return share * speed, turn_rate

    def _caught_up_turn(self, turn_rate: float) -> float:
        """Return the turn rate nearest to a wanted one, in [rad/s], that the base reaches in this period.

        A base that has to stay on its arc gets the wanted one.
        """
        if self._slows_turns or not self._slowed_turn:
            return turn_rate
        last, most = self._last.turn_rate, self._turn_braking * self._period
        reached = max(last - most, min(last + most, turn_rate))
        self._slowed_turn = reached != turn_rate
        return reached

    def _seeing(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """Return a command, or while the lidar repeats an old scan, the part of it by which the base comes to
        rest.

        Args:
            speed: speed in the direction of travel, in [m/s].
            turn_rate: turn rate to the left, in [rad/s].

        Returns:
            Speed in [m/s] and turn rate in [rad/s].
        """
        if not self._is_blind():
            self._blind_speed = math.inf
            return speed, turn_rate
        self._blind_speed = max(0.0, min(self._blind_speed, abs(speed)) - self._braking * self._period)
        self._slowed_to = min(self._slowed_to, self._blind_speed)
        share = self._blind_speed / abs(speed) if speed != 0.0 else 0.0
        return share * speed, share * turn_rate

    @property
    def yields(self) -> bool:
        """True if the base stopped for a person in the last period although it was commanded to drive."""
        return self.share_for_people == 0.0

    @property
    def felt(self) -> FloatArray:
        """Points (n, 2) on the map, in [m], that the base avoids because it touched something there."""
        return self._felt

    def taken(self) -> tuple[DriveCommand, HoldingObstacle | None]:
        """Return the command that was sent to the base in this period, and start the next period with zero
        speed.

        Returns:
            The command, which is zero if none was sent; and the obstacle that made the base slower than
            commanded, None without one.
        """
        taken = self._command, self._held
        self.share_for_people, self._share, self._people = self._share, 1.0, None
        self._last, self._command, self._held = self._command, DriveCommand(), None
        return taken

    def _begin(self) -> None:
        self._change_frame()
        if self._starts:
            pose = self._pose()
            self._restart_scan()
            self._guard.stand_at(pose, self._around(pose))
            if self._unseen is not None:
                self._unseen.starts_here()
            self._starts = False

    def _around(self, pose: Pose2) -> FloatArray:
        """Return the points (n, 2) of the scan and of felt obstacles in the base frame, in [m].

        Args:
            pose: map_T_base.
        """
        scan = self._scan()
        is_felt = self._on_map and len(self._felt) > 0
        return np.vstack([scan, pose.inverse().apply(self._felt)]) if is_felt else scan

    def _caught_up(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """Return a command whose speed and turn rate grow by no more than the base accelerates.

        It is needed because the caller does not know that the base was held back in the last period.

        Args:
            speed: speed in the direction of travel, in [m/s].
            turn_rate: turn rate to the left, in [rad/s].
        """
        most = self._slowed_to + self._braking * self._period
        turn_rate = self._caught_up_turn(turn_rate)
        if abs(speed) <= most:
            self._slowed_to = math.inf
            return speed, turn_rate
        return math.copysign(most, speed), turn_rate * (most / abs(speed) if self._slows_turns else 1.0)

    def _allowed(self, speed: float, turn_rate: float, direction: float) -> tuple[float, float]:
        """Return the part of a command that is free of obstacles until the base could stop.

        The base is guarded as one that heads in the direction of travel, with its footprint turned back by as
        much.

        Args:
            speed: speed in the direction of travel, in [m/s].
            turn_rate: turn rate to the left, in [rad/s].
            direction: direction of travel in the base frame, in [rad], counter-clockwise from straight ahead.

        Returns:
            Speed in [m/s] and turn rate in [rad/s].
        """
        self._begin()
        pose = self._pose()
        scan = self._around(pose)
        if direction != 0.0:
            base_T_way = Pose2(0.0, 0.0, direction)
            pose, scan = pose.compose(base_T_way), base_T_way.inverse().apply(scan)
        for share in SPEED_RATIOS:
            slower, turn = share * speed, turn_rate * (share if self._slows_turns else 1.0)
            held = self._touched(pose, scan, slower, turn, direction)
            if held is None:
                self._slowed_to = abs(slower) if self._held or self._slowed_to < math.inf else math.inf
                return slower, turn
            self._held = self._felt_or_seen(held)
        self._slowed_to = 0.0
        return 0.0, self._free_turn(pose, scan, turn_rate, direction)

    @property
    def _slows_turns(self) -> bool:
        """True if a slower command turns more slowly, too, so that the base stays on the same arc."""
        return self._is_car or not self._shape.is_disc

    def _touched(
        self, pose: Pose2, scan: FloatArray, speed: float, turn_rate: float, direction: float
    ) -> HoldingObstacle | None:
        """Return the obstacle that the base would touch until it could stop; None if its way is free.

        Args:
            pose: pose on the map that heads in the direction of travel.
            scan: (n, 2) points in the frame of that pose, in [m].
            speed: speed in the direction of travel, in [m/s].
            turn_rate: turn rate to the left, in [rad/s].
            direction: direction of travel in the base frame, in [rad], counter-clockwise from straight ahead.
        """
        way = self._way_to_stop(speed)
        if isinstance(self._guard, FootprintGuard):
            view = None if self._unseen is None else self._unseen.view
            turn = turn_rate * self._period + turn_rate * abs(turn_rate) / (2.0 * self._turn_braking)
            held = self._guard.free_motion(pose, scan, way, turn, view, direction)
        else:
            held = self._guard.free_way(pose, scan, turn_rate / speed, way)[1]
        if held is None and self._unseen is not None and speed != 0.0:
            return self._unseen.held(pose, turn_rate / speed, way, direction)
        return held

    def _free_turn(self, pose: Pose2, scan: FloatArray, turn_rate: float, direction: float) -> float:
        """Return the part of a turn in place, in [rad/s], that is free; arguments as for `_touched`."""
        if self._is_car:
            return 0.0
        if self._shape.is_disc:
            return turn_rate
        for share in SPEED_RATIOS:
            if not self._touched(pose, scan, 0.0, share * turn_rate, direction):
                return share * turn_rate
        return 0.0

    def _felt_or_seen(self, held: HoldingObstacle) -> HoldingObstacle:
        there = self._felt - (held.x, held.y)
        felt = held.shown_by == "scan" and bool(np.any(np.hypot(*there.T) < SAME_POINT_M))
        return held._replace(shown_by="contact") if felt else held

    def _way_to_stop(self, speed: float) -> float:
        """Return the distance driven in this period and while braking, in [m]; below zero backwards."""
        return speed * self._period + speed * abs(speed) / (2.0 * self._braking)


def steady_points(scan: Scan) -> FloatArray:
    """Return the points (n, 2) of a scan in the base frame, in [m], without single readings that are too
    short.

    Each range is replaced by the median of itself and its two neighbours, because a single short reading may
    be noise, and the minimum of hundreds of noisy readings is always too short. Beams that show neither an
    obstacle nor free ground are skipped.
    """
    is_read = len(scan.validity) > 0  # then a range is finite or infinity
    ranges = scan.ranges if is_read else np.where(np.isfinite(scan.ranges), scan.ranges, np.inf)
    if len(ranges) < 3:
        return scan.points() if len(ranges) else NO_STANDS
    angles, goes_round = scan.angles, _goes_round(scan.angles)
    if is_read and (blind := scan.blind()).any():
        angles, ranges = angles[~blind], ranges[~blind]
        if len(ranges) == 0:
            return NO_STANDS
    first, last = (ranges[:1], ranges[-1:]) if goes_round else (_FAR, _FAR)
    before, after = np.concatenate((last, ranges[:-1])), np.concatenate((ranges[1:], first))
    low, high = np.minimum(before, after), np.maximum(before, after)
    return scan._replace(angles=angles, ranges=np.maximum(low, np.minimum(high, ranges))).points()


def _goes_round(angles: FloatArray) -> bool:
    """Return whether the last beam of a scan is the neighbour of the first one, by the beams' angles (n,) in
    [rad].
    """
    spacing = (angles[-1] - angles[0]) / (len(angles) - 1)
    return bool(angles[-1] - angles[0] + 1.5 * spacing > 2.0 * np.pi)
