"""EXPLORE: draw the map of a building by driving to where the known ground ends."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.lidar_watch import LidarWatch
from handcart.primitives.driving.scan_collector import ScanCollector
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.drawn_map import DrawnMap
from handcart.primitives.restoring.snapshot import Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .explored_picture import explored_picture
from .exploring_drive import GOAL_NAME, ExploringDrive, looking_at
from .exploring_look import ExploringLook, FrontierGoal, FrontierLook
from .exploring_return import drive_to_start
from .exploring_turn import turn_by
from .map_work import MapWork

ALL_AROUND_RAD = math.radians(300.0)  # of view, from where turning on the spot shows nothing new
TURN_STEPS = 3  # of a full turn
LOOK_DISTANCE_M = 1.5  # driven, after which the map is drawn again
LOOK_PERIOD_S = 3.0  # the same in time
LOOK_S = 0.2  # of the robot's time, for drawing and planning
FINISH_S = 2.0  # of the robot's time, for the last search for loops
SAME_FRAME_M, SAME_FRAME_RAD = 0.03, math.radians(1.0)  # of poses that count as equal: the drive continues
NEAR_FRONTIER_M = 0.8  # beside the footprint, up to where a frontier is looked at from nearby
MAX_DRIVES = 3  # that may fail to one frontier
MAX_BLIND_SHARE = 0.1  # of the motions that only the wheels measured, from which a map is doubtful
MIN_EXPLAINED = 0.5  # share of the last scan that the map must explain
GETTING_ON_M = 0.1  # less is not progress
STANDING_TIMEOUT_S = 180.0  # without progress, with drives that are changed again and again
STANDING_RATIO = 4.0  # of the time to wait for a passer-by, if that is more
TRIED_AGAIN = (causes.BLOCKED, causes.NO_ROUTE, causes.OFF_GOAL, causes.UNDETERMINED)


class Explore(ActionPrimitive):
    """Draw a map by driving to frontiers, where known ground borders on unknown, until none is left to cross.

    The map begins empty (`map: none`), or with the given map. It is made from scans and wheel odometry by a
    pose graph with keyframes and loop closures, as by `handcart map`. Success means that the map has no
    reachable frontier larger than the robot; the findings state how much of the border stays unknown, and
    why. The map is saved in the run's folder, also after a Fail. After a Fail the base is back at its start,
    checked by a scan.
    """

    radius_m: Annotated[float, Field(gt=0.0, le=1000.0)] = 100.0
    """Straight distance from the start beyond which frontiers are not explored."""
    longest_m: Annotated[float, Field(gt=0.0, le=1e5)] = 2000.0
    """Maximum distance to drive."""
    resolution_m: Annotated[float, Field(ge=0.01, le=0.2)] = 0.03
    """Side of a cell of the saved map."""
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_\-]{1,40}$")] = "explored"
    """Name of the saved map."""
    wait_s: Annotated[float, Field(ge=0.0, le=600.0)] = 5.0
    """Time to wait for a passer-by to leave the path."""

    needs: ClassVar = (Base, RangeSensor)
    reads: ClassVar = ("map", "obstacles", "bumps", "arm_bumps")
    writes: ClassVar = ("sensed_cells",)
    arm_inside: ClassVar = True
    draws_map: ClassVar = True

    _scans: ScanCollector | None = PrivateAttr(default=None)
    _work: MapWork | None = PrivateAttr(default=None)
    _look: ExploringLook | None = PrivateAttr(default=None)
    _last: FrontierLook | None = PrivateAttr(default=None)
    _failed: dict[tuple[float, float], int] = PrivateAttr(default_factory=dict)
    _lidar_watch: LidarWatch = PrivateAttr(default_factory=LidarWatch)
    _got_on_m: float = PrivateAttr(default=0.0)
    _got_on_at: float = PrivateAttr(default=0.0)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the robot cannot compare scans with a map, or cannot turn on the spot."""
        if robot.spec.drive.kind == "ackermann":
            return "a car-like base does not explore: it cannot turn on the spot"
        if not robot.localization.can_relocate:
            source = robot.localization.source
            return f"EXPLORE needs a lidar, and the localizer scan or odometry; the pose is by {source}"
        return ""

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        assert robot.lidar is not None
        known = model.map if model.map.occupied.any() else None
        self._scans = ScanCollector(robot, robot.lidar, known)
        self._work, self._got_on_at = MapWork(self._scans), robot.time
        self._look = ExploringLook(robot, self._scans.map, self.radius_m)
        yield from self._look_around(robot)
        target = yield from self._next_target(robot, model)
        while target is not None:
            target = yield from self._drive(robot, model, target)
        yield from settle(robot)
        yield from self._finish(robot, model)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether a scan at rest agrees with the map, and no frontier is left to explore."""
        assert self._scans is not None and self._look is not None and self._last is not None
        yield
        points = self._scans.look().hits
        off = self._last.field.read(robot.pose.apply(points))
        share = float((off < 2.0 * self._last.grid.resolution).mean()) if len(points) else 0.0
        self.found(last_scan_explained=round(share, 3))
        return share >= MIN_EXPLAINED and self._last.target is None

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Collect the lidar's scan of the current control period for the map that is being made.

        Raises:
            NeedsPerson: the lidar is covered, or localization reports that the robot's pose is unknown.
        """
        self._lidar_watch.watch(robot, None)
        lost = robot.localization.lost
        if lost is not None:
            raise NeedsPerson(
                f"the robot doesn't know where it is: {lost.why}", Measured(*lost[1:]), cause=causes.LOST
            )
        if self._scans is not None:
            self._scans.take(robot)

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        if self._scans is None or self._work is None or self._look is None:
            return
        yield from self._work.drain()
        self._save(robot)
        yield from drive_to_start(robot, model, start, self._scans, self._work, self._look)

    # Driving

    def _look_around(self, robot: Robot) -> Periods:
        """Turn once on the spot if the lidar does not see all around: a route begins on ground that is seen.

        A base that is held back at its place looks as far as it can turn.
        """
        assert robot.lidar is not None
        if float(np.ptp(robot.lidar.scan().angles)) >= ALL_AROUND_RAD:
            return
        for _ in range(TURN_STEPS):
            if not (yield from turn_by(robot, 2.0 * math.pi / TURN_STEPS)):
                return

    def _next_target(self, robot: Robot, model: ModelView) -> Generator[None, None, FrontierGoal | None]:
        """Draw the map from the base's place, and return the next frontier; None if none is left."""
        assert self._scans is not None and self._work is not None and self._look is not None
        look = yield from self._work.run(robot, self._look.take, self._scans.pose, None, takes=LOOK_S)
        self._adopt(robot, look)
        return look.target

    def _drive(
        self, robot: Robot, model: ModelView, target: FrontierGoal
    ) -> Generator[None, None, FrontierGoal | None]:
        """Drive to a frontier, until it is gone or the base is there; return the next target."""
        assert self._scans is not None and self._work is not None and self._look is not None
        assert self._last is not None
        goal = looking_at(target.view, target.middle)
        drive = ExploringDrive(model, self._last.grid, goal, self.wait_s, GOAL_NAME)
        periods = drive.periods(robot)
        looked_at, looked = self._scans.rolled, robot.time
        while not drive.is_near(robot.pose):
            self._check_distance(robot)
            is_due = self._scans.rolled > looked_at + LOOK_DISTANCE_M or robot.time > looked + LOOK_PERIOD_S
            if is_due and not self._work.is_running:
                looked_at, looked = self._scans.rolled, robot.time
                self._work.begin(robot, self._look.take, self._scans.pose, target, takes=LOOK_S)
            result = self._work.advance() if self._work.is_running else None
            if result is not None and not self._goes_on(robot, result[0], target):
                self._adopt(robot, result[0])
                return result[0].target  # type: ignore[no-any-return]
            try:
                next(periods)
            except StopIteration:
                break
            except Discrepancy as wrong:
                self._note_failure(target, wrong)
                break
            yield
        yield from self._work.drain()
        return (yield from self._arrived(robot, model, target))

    def _arrived(
        self, robot: Robot, model: ModelView, target: FrontierGoal
    ) -> Generator[None, None, FrontierGoal | None]:
        """Look from a reached frontier, and return the next one; a frontier that stays is given up."""
        assert self._scans is not None and self._look is not None
        yield from settle(robot)
        self._scans.add_here(robot)
        found = yield from self._next_target(robot, model)
        if found is not None and found.is_same(target) and target.middle not in self._failed:
            is_near = robot.pose.distance(Pose2(*found.middle, 0.0)) < NEAR_FRONTIER_M + self._radius(robot)
            self._look.leave(found.middle, "seen" if is_near else "unreachable")
            found = yield from self._next_target(robot, model)
        return found

    def _radius(self, robot: Robot) -> float:
        return robot.spec.footprint_shape.inscribed

    def _goes_on(self, robot: Robot, look: FrontierLook, target: FrontierGoal) -> bool:
        """Return whether the drive still leads to a frontier, in the same frame."""
        assert self._scans is not None
        here = self._scans.pose
        same = robot.pose.distance(here) < SAME_FRAME_M and robot.pose.turn(here) < SAME_FRAME_RAD
        return same and look.target is not None and look.target.is_same(target)

    def _adopt(self, robot: Robot, look: FrontierLook) -> None:
        """Compare scans with the map as it is now."""
        assert self._scans is not None
        self._last = look
        robot.localization.follow_map(look.field, self._scans.pose, look.covariance)
        self.found(**look.facts, driven_m=round(self._scans.rolled, 1))

    def _note_failure(self, target: FrontierGoal, wrong: Discrepancy) -> None:
        """Count a drive that did not get to its frontier; another one is tried first.

        Raises:
            Discrepancy: the base itself does not get on.
        """
        assert self._look is not None
        if wrong.cause not in TRIED_AGAIN:
            raise wrong
        count = self._failed[target.middle] = self._failed.get(target.middle, 0) + 1
        if wrong.permanent:
            self._look.leave(target.middle, "no_route")
        elif count >= MAX_DRIVES:
            raise wrong
        else:
            self._look.postpone(target.middle)

    def _check_distance(self, robot: Robot) -> None:
        """Raise `Discrepancy` if the base has driven too far, or does not get on while its goals change."""
        assert self._scans is not None
        if self._scans.rolled > self._got_on_m + GETTING_ON_M:
            self._got_on_m, self._got_on_at = self._scans.rolled, robot.time
        limit = max(STANDING_TIMEOUT_S, STANDING_RATIO * self.wait_s)
        if robot.time > self._got_on_at + limit:
            stood = Measured("Base", "time without getting on", robot.time - self._got_on_at, limit, "s")
            raise Discrepancy(
                "the base doesn't get on to any frontier", measured=stood, cause=causes.NO_PROGRESS
            )
        if self._scans.rolled <= self.longest_m:
            return
        far = Measured("Base", "distance driven", self._scans.rolled, self.longest_m, "m")
        raise Discrepancy(
            f"frontiers are left after {self.longest_m:g} m",
            permanent=True,
            measured=far,
            cause=causes.TIME_OUT,
        )

    # The end

    def _finish(self, robot: Robot, model: ModelView) -> Periods:
        """Search for loop closures once more, draw the map, and drive on if that shows another frontier."""
        assert self._scans is not None and self._work is not None
        yield from self._work.run(robot, self._scans.map.finish, takes=FINISH_S)
        target = yield from self._next_target(robot, model)
        while target is not None:
            target = yield from self._drive(robot, model, target)
        yield from settle(robot)
        self._save(robot)
        blind, motions = self._scans.map.blind, len(self._scans.map.poses) - 1
        if blind > MAX_BLIND_SHARE * max(10, motions):
            share = Measured(
                "RangeSensor", "share of motions without a match", blind / motions, MAX_BLIND_SHARE
            )
            raise Discrepancy(
                "the map is doubtful: scans do not fit each other", measured=share, cause=causes.UNDETERMINED
            )
        model.sensed_cells = self._cells(model.sensed_cells, robot.time)

    def _cells(self, before: FloatArray, now: float) -> FloatArray:
        """Return the sensed cells `before` (n, 4) with the new map's occupied cells, for later drives on the
        given map.

        The columns are x, y on the map in [m], score, and time of the last hit in [s].
        """
        assert self._last is not None
        points = self._last.grid.to_point(np.argwhere(self._last.grid.occupied))
        rows = np.column_stack([points, np.full((len(points), 2), [12.0, now])])
        return np.vstack([before, rows])

    def _save(self, robot: Robot) -> None:
        """Hand the map to the run's folder, with a picture."""
        assert self._scans is not None and self._look is not None
        times = np.array(self._scans.times[: len(self._scans.map.poses)])
        built = self._scans.map.built(self.resolution_m)
        grid = self._look.draw(self.resolution_m)
        self.evidence.maps[self.name] = DrawnMap(grid, built, times)
        border = None if self._last is None else self._last.border
        self.evidence.pictures["map"] = explored_picture(grid, built, border)
        self.found(keyframes=len(built.rows), loop_closures=len(built.accepted))
