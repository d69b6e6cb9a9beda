"""LOCATE: find the pose of the base on the map without a start pose."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.localization.lidar import beams_of
from handcart.backends.robot.localization.localizations import range_noise
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.following.sideways_tracking import make_tracker
from handcart.robotics.navigation.locating.global_search import same_place
from handcart.robotics.navigation.locating.hypotheses import MIN_EXPLAINED, REFUTED_LOG, Hypotheses
from handcart.robotics.navigation.locating.next_view import (
    MIN_DIFFERENCE,
    Surroundings,
    View,
    look_alike,
    next_view,
)
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField, ScanMatch, match_scan
from handcart.robotics.numerics.arrays import FloatArray

from .lidar_watch import LidarWatch

SPEED_M_S = 0.4  # at most, where nothing is known of the ground but what the lidar shows
ARRIVAL_TOLERANCE = PoseTolerance(position=0.10, heading=0.2)
HELD_TIMEOUT_S = 4.0  # time for which an obstacle may be in the way until another place is chosen
DRIVE_TIMEOUT_S = 60.0  # for one drive
MIN_MOTION_M, MIN_MOTION_RAD = 0.02, 0.05  # of a base that gets on
MAX_LOOKS = 40
MAX_TURN_LOOKS = 3  # turns on the spot at the start, of a lidar that does not see all around
ALL_AROUND_RAD = math.radians(300.0)  # of view, from where turning on the spot shows nothing new
MAX_POSITION_SIGMA_M, MAX_HEADING_SIGMA_RAD = 0.10, math.radians(2.0)  # of a pose that is found
PRIOR_COVARIANCE = (
    np.diag([0.3, 0.3, 0.17]) ** 2
)  # [m², rad²] of the best hypothesis, before its scan is matched
SEARCH_S = 1.0  # of the robot's time, for one search of the map
NAMED_HYPOTHESES = 4


class Locate(ActionPrimitive):
    """Find the pose of the base on the map, by scans alone.

    The first scan is compared with the complete map. As long as several places on the map explain all scans,
    the base drives a short way over ground that the lidar has seen to be free. It goes to where scans from
    these places would differ, and takes another scan. Success means that from one place the scans are a
    million times as likely as from any other. If the map looks alike from several places, the base drives
    back, and the outcome is Fail with these places named.

    If the pose is known and agrees with the scan, nothing moves.
    """

    longest_m: Annotated[float, Field(gt=0.0, le=200.0)] = 25.0
    """Maximum distance to drive."""

    needs: ClassVar = (Base, RangeSensor)
    reads: ClassVar = ("map",)
    arm_inside: ClassVar = True
    needs_pose: ClassVar = False

    _match: ScanMatch | None = PrivateAttr(default=None)
    _hypotheses: Hypotheses | None = PrivateAttr(default=None)
    _field: LikelihoodField | None = PrivateAttr(default=None)
    _lidar_watch: LidarWatch = PrivateAttr(default_factory=LidarWatch)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the robot cannot compare scans with a map, or cannot turn on the spot."""
        if robot.spec.drive.kind == "ackermann":
            return "a car-like base is not localized by LOCATE: it cannot turn on the spot"
        if not robot.localization.can_relocate:
            source = robot.localization.source
            return f"LOCATE needs a map, a lidar, and the localizer scan or odometry; the pose is by {source}"
        if not model.map.occupied.any():
            return "the map shows nothing that a scan could be compared with"
        return ""

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        self._field = LikelihoodField(model.map)
        self._hypotheses = hypotheses = Hypotheses(self._field, range_noise(robot.spec))
        yield from self._look(robot, hypotheses)
        if self._is_known(robot, hypotheses):
            self.found(looks=1, driven_m=0.0)
            return
        robot.localization.forget_pose()
        yield from self._look_around(robot, hypotheses)
        assert robot.lidar is not None
        driven, reach = 0.0, robot.lidar.spec.reach_m
        tried = [np.array([robot.pose.x, robot.pose.y])]
        while not self._is_found(robot, hypotheses):
            poses = hypotheses.poses[hypotheses.alive]
            around = self._surroundings(robot, np.array(tried))
            view = yield from robot.compute(self._next_view, around, poses, self.longest_m - driven, reach)
            if view is None:
                raise self._undecided(hypotheses, driven)
            driven += yield from self._drive(robot, view.route)
            tried += [view.route[-1], np.array([robot.pose.x, robot.pose.y])]
            self.found(driven_m=round(driven, 2))
            yield from self._look(robot, hypotheses)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether one more scan at rest confirms the found pose; if so, set the localizer to it."""
        if self._match is None:
            return True
        yield
        assert self._field is not None
        match = self._matched(robot, self._match.pose)
        if (
            match.inliers < MIN_EXPLAINED
            or not same_place(np.array([match.pose]), np.array(self._match.pose)).all()
        ):
            return False
        robot.localization.locate(match.pose, match.covariance)
        self.evidence.points["scan"] = robot.pose.apply(robot.range_sensor.scan().points())
        return True

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Check the lidar and the odometry, once in each control period.

        Raises:
            NeedsPerson: the lidar is covered, or the base's motion since the start is unknown, because
                localization reports that odometry has failed.
        """
        self._lidar_watch.watch(robot, None)
        lost = robot.localization.lost
        if lost is not None and not robot.localization.is_located:
            raise NeedsPerson(
                f"LOCATE does not know the way it came: {lost.why}", Measured(*lost[1:]), cause=causes.LOST
            )

    # Looking

    def _look(self, robot: Robot, hypotheses: Hypotheses) -> Periods:
        """Compare a scan at rest with all hypotheses, and with the map."""
        yield from settle(robot)
        lidar = robot.lidar
        if lidar is None or lidar.silence:
            silence = "there is no lidar" if lidar is None else lidar.silence
            raise Discrepancy(
                silence, measured=Measured("RangeSensor", "echoes of a scan"), cause=causes.SENSOR_FAULT
            )
        beams = beams_of(lidar)
        yield from robot.compute(hypotheses.take, beams, robot.pose, takes=SEARCH_S)
        alive = hypotheses.alive
        self.evidence.points["hypotheses"] = hypotheses.poses[alive]
        self.found(
            looks=len(hypotheses.looks),
            hypotheses=len(alive),
            explained=round(hypotheses.share, 3),
            log_odds=round(min(hypotheses.margin, 1e3), 1),
        )

    def _look_around(self, robot: Robot, hypotheses: Hypotheses) -> Periods:
        """Turn on the spot where the lidar does not see all around."""
        assert robot.lidar is not None
        angles = robot.lidar.scan().angles
        view = float(np.ptp(angles))
        if view >= ALL_AROUND_RAD:
            return
        for _ in range(MAX_TURN_LOOKS):
            if hypotheses.is_unique:
                return
            yield from self._turn(robot, math.radians(90.0))
            yield from self._look(robot, hypotheses)

    def _turn(self, robot: Robot, angle: float) -> Periods:
        goal = robot.pose.theta + angle
        here = np.array([[robot.pose.x, robot.pose.y]])
        tracker = make_tracker(here, goal, robot.drive_limits, tolerance=ARRIVAL_TOLERANCE)
        end = robot.time + 4.0 * HELD_TIMEOUT_S
        while not tracker.finished(robot.pose) and robot.time < end:
            robot.base.drive(*tracker.command(robot.pose, robot.period))
            yield

    def _drive(self, robot: Robot, route: FloatArray) -> Generator[None, None, float]:
        """Drive along a route, up to where something holds the base back; return the distance, in [m].

        Args:
            robot: the robot.
            route: (n, 2) points in the frame of the present pose, in [m].
        """
        limits = robot.drive_limits
        limits = limits._replace(speed=min(limits.speed, SPEED_M_S))
        tracker = make_tracker(route, None, limits, tolerance=ARRIVAL_TOLERANCE)
        since, stood, held, begun = robot.time, robot.pose, False, robot.time
        end = begun + DRIVE_TIMEOUT_S
        while not tracker.finished(robot.pose) and robot.time < min(end, since + HELD_TIMEOUT_S):
            held = held or robot.held is not None
            if _has_moved(stood, robot.pose):
                since, stood, held = robot.time, robot.pose, False
            robot.base.drive(*tracker.command(robot.pose, robot.period))
            yield
        if not tracker.finished(robot.pose) and not held:
            driven = Measured(
                "Base", "time driven without getting on", robot.time - since, HELD_TIMEOUT_S, "s"
            )
            raise Discrepancy("the base doesn't get on", measured=driven, cause=causes.NO_PROGRESS)
        return tracker.progress

    def _surroundings(self, robot: Robot, tried: FloatArray) -> Surroundings:
        seen = robot.localization.local_map
        assert seen is not None, "the pose was forgotten"
        return Surroundings(seen.grid, robot.pose, robot.spec.footprint_radius_m, tried)

    def _next_view(self, around: Surroundings, poses: FloatArray, left: float, reach: float) -> View | None:
        """Return the next place to look from; None if no place within reach would distinguish the poses
        better.

        Args:
            around: surroundings of the robot, as sensed so far.
            poses: (n, 3) map_T_base of the remaining hypotheses, x, y in [m] and heading in [rad], the best
                first.
            left: distance that the robot may still drive, in [m].
            reach: range of the lidar, in [m].
        """
        assert self._field is not None
        if left <= 0.0 or (self._hypotheses is not None and len(self._hypotheses.looks) >= MAX_LOOKS):
            return None
        view = next_view(around, self._field, poses, reach)
        is_useless = view is not None and view.difference < MIN_DIFFERENCE and len(poses) > 1
        if is_useless and look_alike(self._field, poses, around.radius, left, reach):
            return None
        return view

    # Deciding

    def _is_known(self, robot: Robot, hypotheses: Hypotheses) -> bool:
        """Return whether the pose was known before, and the scan does not refute it."""
        where = robot.localization
        if not where.is_located or where.lost is not None or not hypotheses.is_explained:
            return False
        alive = hypotheses.poses[hypotheses.alive]
        return bool(same_place(alive, np.array(robot.pose)).any())

    def _is_found(self, robot: Robot, hypotheses: Hypotheses) -> bool:
        """Return whether one hypothesis is left, and its scan determines the pose in each direction."""
        if not hypotheses.is_unique:
            return False
        match = self._matched(robot, Pose2(*hypotheses.poses[0].tolist()))
        variance = np.linalg.eigvalsh(match.covariance[:2, :2])[-1]
        is_sharp = variance <= MAX_POSITION_SIGMA_M**2
        is_sharp = bool(is_sharp and match.covariance[2, 2] <= MAX_HEADING_SIGMA_RAD**2)
        self._match = match if is_sharp else None
        return is_sharp

    def _matched(self, robot: Robot, near: Pose2) -> ScanMatch:
        assert self._field is not None
        points = robot.range_sensor.scan().points()
        return match_scan(self._field, points, near, PRIOR_COVARIANCE, range_noise(robot.spec))

    def _undecided(self, hypotheses: Hypotheses, driven: float) -> Discrepancy:
        """Return the permanent Discrepancy that no single place is left, with the places named."""
        alive = hypotheses.alive
        if not hypotheses.is_explained:
            share = Measured("RangeSensor", "share of the scans that the map explains", hypotheses.share)
            words = "no place on the map explains the scans"
            return Discrepancy(
                words, permanent=True, measured=share._replace(limit=MIN_EXPLAINED), cause=causes.LOST
            )
        odds = min(hypotheses.margin, REFUTED_LOG)
        margin = Measured("RangeSensor", "log-odds of the best place", odds, REFUTED_LOG)
        if len(alive) == 1:
            words = f"the scans do not determine where along its walls the base is: {_named(hypotheses, 1)}"
            return Discrepancy(words, permanent=True, measured=margin, cause=causes.UNDETERMINED)
        places = _named(hypotheses, len(alive))
        words = f"ambiguous: after {driven:.1f} m {len(alive)} places explain the scans alike: {places}"
        return Discrepancy(words, permanent=True, measured=margin, cause=causes.AMBIGUOUS)


def _has_moved(before: Pose2, now: Pose2) -> bool:
    return before.distance(now) > MIN_MOTION_M or before.turn(now) > MIN_MOTION_RAD


def _named(hypotheses: Hypotheses, count: int) -> str:
    poses = hypotheses.poses[hypotheses.alive][: min(count, NAMED_HYPOTHESES)].tolist()
    listed = [f"({x:.2f}, {y:.2f}) m {math.degrees(turn):.0f} deg" for x, y, turn in poses]
    more = f" and {count - len(listed)} more" if count > len(listed) else ""
    return ", ".join(listed) + more
