"""MOVE_TO: drive the base to a named place."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from functools import partial
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.localization.determination import PoseNeed, difference, room_left, undetermined
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.bumps import remember_bump
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.preconditions.hand_use import USE_UNDECLARED, USES_NO_FINGERS, HandUse
from handcart.primitives.restoring.retrace import reach_pose, retrace
from handcart.primitives.restoring.return_progress import HELD_RETURN_S, STUCK_RETURN_S
from handcart.primitives.restoring.snapshot import Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.car_tracker import CarTracker
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.following.sideways_tracking import make_tracker
from handcart.robotics.numerics.arrays import FloatArray

from .docking import DOCK_TOLERANCE, check_determined, dock
from .driving import (
    WATCH_HORIZON_M,
    FieldObstacleMonitor,
    ObstacleMonitor,
    goal_pose,
    held_before,
    make_monitor,
    plan_tracker,
)
from .early_forecast import check_will_be_determined
from .lidar_watch import LidarWatch
from .local_replanning import LocalReplanning
from .looks_at_rest import LooksAtRest
from .place_measuring import measure_place, until_blocked
from .waiting_limit import WaitingLimit
from .way_back import brake, drive_back, way_back_blocked

ARRIVAL_TOLERANCE = PoseTolerance(position=0.02, heading=0.01)
STUCK_TIMEOUT_S = 6.0  # without getting on, though nothing is seen in the way
REPLAN_DELAY_S = 2.0  # that what the map shows may hold it, until another route is planned from there
REPLAN_MAX_TRIES = 3  # times that this is done
SLIP_DISTANCE_M = 0.1  # that the base was driven meanwhile: something stops it
MAX_CORRECTIONS = 3  # times that a base which drives by its wheels alone is led on after a look at rest
REPLAN_DISTANCE_M = 0.3  # off the goal, from where a route is planned again
CLOSER_NEED_RATIO = 0.8  # of what a place needs: the estimate changes until the base is at rest
FINAL_APPROACH_M = 0.05  # before the goal, where it turns and stops


class MoveTo(ActionPrimitive):
    """Drive the base to a named place along the Voronoi graph, and dock before an object's straight front.

    Odometry is corrected by comparing scans with the map. A car drives arcs and straight lines past the
    rocks of its field, with its outdoor localization. MOVE_TO drives around unmapped obstacles as long as a
    route exists. Without a route, and always with `detour: false`, it waits; if the obstacle stays, the
    outcome is Fail, and the sensed obstacles are kept in the world model.
    """

    place: PlaceName
    """Name of the place to drive to."""
    wait_s: Annotated[float, Field(ge=0.0, le=600.0)] = 5.0
    """Time to wait for a passer-by to leave the path."""
    reverse: bool = False
    """True to drive backwards, where turning around would sweep the base's rear over something."""
    detour: bool = True
    """True to drive around unmapped obstacles; False to wait before them, then Fail."""
    together: bool = False
    """True to move the arm during the drive, as the place's domain defines."""

    needs: ClassVar = (Base, RangeSensor)
    reads: ClassVar = ("map", "places", "speed_limits", "discs")
    writes: ClassVar = ("obstacles", "sensed_cells", "bumps", "arm_bumps", "detour")

    arm_inside: ClassVar = True

    _monitor: ObstacleMonitor | FieldObstacleMonitor | None = PrivateAttr(default=None)
    _local: LocalReplanning | None = PrivateAttr(default=None)
    _ahead: FloatArray = PrivateAttr(default_factory=lambda: np.empty((0, 2)))
    _blocked_since: float | None = PrivateAttr(default=None)
    _restores: bool = PrivateAttr(default=False)
    _driven: float = PrivateAttr(default=0.0)
    _lidar_watch: LidarWatch = PrivateAttr(default_factory=LidarWatch)

    @override
    def hand_use(self) -> HandUse:
        return USE_UNDECLARED if self.together else USES_NO_FINGERS

    @override
    def needs_arm_inside(self) -> bool:
        return not self.together

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the arm should move during the drive, but cannot; empty otherwise.

        The robot may have no arm with a gripper, or no arm motion may be known for the place.
        """
        if not self.together:
            return ""
        if robot.backend.get(Arm) is None or robot.backend.get(Gripper) is None:  # type: ignore[type-abstract]
            return "the robot has no arm with a gripper to move along"
        known = model.companion(robot, self.place) is not None
        return "" if known else f"nothing is known that the arm could do on the way to {self.place!r}"

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        goal, is_car = goal_pose(model, self.place), robot.spec.drive.kind == "ackermann"
        if self.detour and not is_car:
            yield from measure_place(robot, model, self.place, partial(self._drive, robot, model), self.found)
            goal = goal_pose(model, self.place)
        place, need = self._place_and_need(robot, model)
        self._monitor = make_monitor(robot, model)
        if place.docks or model.is_redrawn():
            robot.base.may_stand_at(goal)
        if self.detour and not is_car:
            self._local = LocalReplanning(robot, model, self.place)
        tracker, points = yield from self._planned(robot, model, goal)
        self.evidence.points["planned"] = points
        yield from check_will_be_determined(robot, model.map, self.place, place, need, points)
        yield from self._follow(robot, model, tracker)
        if robot.localization.dead_reckoned and not is_car:
            yield from self._follow_again(robot, model, goal)
        if place.docks:
            yield from dock(robot, self.place, place, need, self.found)
        elif not is_car:
            yield from self._come_closer(robot, place, need)
        if self._local is not None:
            self._local.keep()
        self.evidence.points["scan"] = robot.pose.apply(robot.range_sensor.scan().points())
        if model.detour and model.detour.goal == self.place:
            model.detour = None

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return True if the base is at the place within its tolerance, given the uncertainty of its pose.

        Raises:
            Discrepancy: the base may be outside the tolerance, because its pose is too uncertain.
        """
        check_determined(robot, self.place, *self._place_and_need(robot, model))
        return True
        yield

    def _drive(self, robot: Robot, model: ModelView, place: Place) -> Periods:
        """Drive to a place on the way to the named one, as long as a way leads there."""
        self._monitor = make_monitor(robot, model)
        self._local = LocalReplanning(robot, model, self.place, place)
        tracker, _ = yield from self._planned(robot, model, place.pose)
        drive = self._follow(robot, model, tracker)
        yield from until_blocked(drive, robot, lambda: self._blocked_since, 0.5 * self.wait_s)
        self._ahead, self._blocked_since = np.empty((0, 2)), None
        self._local.keep()

    def _place_and_need(self, robot: Robot, model: ModelView) -> tuple[Place, PoseNeed]:
        """Return the place, and the required accuracy of this base's pose there."""
        place = model.places[self.place]
        return place, place.need_of(robot.spec.drive.kind)

    def _arrived(self, robot: Robot, model: ModelView) -> PoseTolerance:
        """Return the tolerance of the controller; half of the place's tolerance is left for uncertainty."""
        _, need = self._place_and_need(robot, model)
        return PoseTolerance(
            min(ARRIVAL_TOLERANCE.position, 0.5 * need.strictest),
            min(ARRIVAL_TOLERANCE.heading, 0.5 * need.heading),
        )

    def _come_closer(self, robot: Robot, place: Place, need: PoseNeed) -> Periods:
        """Approach more exactly if offset and uncertainty together come near the place's tolerance."""
        pose, off = robot.localization.repeatability, difference(robot.pose, place.pose)
        shift = robot.localization.map_shift
        if (
            undetermined(pose, need.scaled(CLOSER_NEED_RATIO), off, shift) is None
            or undetermined(pose, need, shift=shift) is not None
        ):
            return
        room = room_left(pose, need, shift)
        closer = PoseTolerance(
            max(DOCK_TOLERANCE.position, min(ARRIVAL_TOLERANCE.position, 0.5 * room[0])),
            max(DOCK_TOLERANCE.heading, min(ARRIVAL_TOLERANCE.heading, 0.5 * room[1])),
        )
        yield from reach_pose(robot, place.pose, closer)
        yield from settle(robot)

    def _arm(self, robot: Robot, model: ModelView, remaining: Callable[[], float]) -> Iterator[None]:
        """Return the arm's motion during the drive."""
        companion = model.companion(robot, self.place) if self.together else None
        return iter(()) if companion is None else companion.motion(remaining)

    def _planned(
        self, robot: Robot, model: ModelView, goal: Pose2
    ) -> Generator[None, None, tuple[PathTracker | CarTracker, FloatArray]]:
        """Return a tracker for a route from here, and its points (n, 2) in [m]."""
        arrived = self._arrived(robot, model)
        if self._local is None:
            return (yield from plan_tracker(robot, model, self.place, goal, arrived, self.reverse))
        look = yield from self._local.plan(robot)
        limits = robot.drive_limits
        tracker = make_tracker(look.points, goal.theta, limits, self.reverse, arrived, look.speeds)
        return tracker, look.points

    def _replanned(self, robot: Robot, tracker: PathTracker | CarTracker) -> Periods:
        """Change the tracker's route where what is sensed asks for it; back off if the base is pinned."""
        if (local := self._local) is None or not isinstance(tracker, PathTracker):
            return
        local.update(robot, tracker)
        self._blocked_since = local.waits_since
        if local.pinned(robot):
            yield from local.back_off(robot, tracker)

    def _command(self, robot: Robot, tracker: PathTracker | CarTracker, looks: bool) -> tuple[float, ...]:
        """Return the drive command along the route; to hold before obstacles and for scans at rest."""
        local = self._local if isinstance(tracker, PathTracker) else None
        if looks or (local is None and self._blocked_since is not None):
            return tracker.hold(robot.pose, robot.period)
        if local is None or not isinstance(tracker, PathTracker):
            return tracker.command(robot.pose, robot.period)
        return local.command(robot, tracker)

    def _follow(self, robot: Robot, model: ModelView, tracker: PathTracker | CarTracker) -> Periods:
        arm = self._arm(robot, model, lambda: tracker.remaining)
        progress, since, rolled, last = 0.0, robot.time, 0.0, robot.localization.odometry_pose
        anew, looks, waiting = 0, LooksAtRest(robot.localization), WaitingLimit(self.place, self.wait_s)
        while not tracker.finished(robot.pose):
            yield from self._replanned(robot, tracker)
            due = looks.due(tracker.remaining)
            waits = due or self._blocked_since is not None or robot.base.share_for_people < 1.0
            waits = waits or robot.localization.stale_s > 0.0
            waiting.note(robot, tracker.remaining, waits)
            robot.base.drive(*self._command(robot, tracker, due))
            self._ahead = tracker.ahead
            if abs(tracker.progress - progress) > 0.01 or waits:
                progress, since, rolled = tracker.progress, robot.time, 0.0
            if (
                anew < REPLAN_MAX_TRIES
                and robot.time > since + REPLAN_DELAY_S
                and self._held_by_map(robot, model)
            ):
                tracker, _ = yield from self._planned(robot, model, goal_pose(model, self.place))
                progress, since, anew = 0.0, robot.time, anew + 1
            if robot.time > since + self._patience(robot, tracker):
                raise self._stuck(robot, model, robot.time - since, rolled)
            next(arm, None)
            yield
            rolled += abs(robot.command.along) * robot.period
            self._driven += robot.localization.odometry_pose.distance(last)
            last = robot.localization.odometry_pose
            self.found(path_length_m=round(self._driven, 3))
        self._ahead, self._blocked_since = np.empty((0, 2)), None
        yield from arm

    def _follow_again(self, robot: Robot, model: ModelView, goal: Pose2) -> Periods:
        """Drive on if a scan at rest shows that the base is not where its wheels say."""
        arrived = self._arrived(robot, model)
        for _ in range(MAX_CORRECTIONS):
            yield from settle(robot)
            if robot.pose.distance(goal) < arrived.position and robot.pose.turn(goal) < arrived.heading:
                return
            if robot.pose.distance(goal) < REPLAN_DISTANCE_M:
                yield from reach_pose(robot, goal, arrived)
                continue
            tracker, _ = yield from self._planned(robot, model, goal)
            yield from self._follow(robot, model, tracker)

    def _held_by_map(self, robot: Robot, model: ModelView) -> bool:
        """Return whether the base came off its route towards a wall, so that a new one leads away first."""
        detour = model.detour is not None and model.detour.goal == self.place
        return robot.held is not None and robot.held.shown_by == "map" and not detour

    def _patience(self, robot: Robot, tracker: PathTracker | CarTracker) -> float:
        """Return the maximum time without progress, in [s]."""
        if robot.held is not None:
            return max(STUCK_TIMEOUT_S, self.wait_s)
        return STUCK_TIMEOUT_S if tracker.remaining > FINAL_APPROACH_M else STUCK_RETURN_S

    def _stuck(self, robot: Robot, model: ModelView, seconds: float, rolled: float) -> Discrepancy:
        """Return the reason for the missing progress; scanned obstacles on the path are kept."""
        held = robot.held
        if held is None:
            stood = Measured("Base", "time without getting on", seconds, STUCK_TIMEOUT_S, "s")
            touches = "its wheels slip, or it touches something that neither map nor scan shows"
            why = f": {touches}" if rolled > SLIP_DISTANCE_M else ""
            remember_bump(robot, model, forwards=not self.reverse)
            return Discrepancy(f"the base doesn't get on{why}", measured=stood, cause=causes.NO_PROGRESS)
        if held.shown_by == "scan" and self._monitor is not None:
            found = self._monitor.around(robot, np.array([held.x, held.y]))
            model.obstacles = np.vstack([model.obstacles, found])
        return held_before(self.place, held)

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Stop the base before an unexpected obstacle on its route; raise `Discrepancy` if the obstacle stays
        for `wait_s` seconds.
        """
        lost = robot.localization.lost
        if lost is not None:
            raise NeedsPerson(
                f"the robot doesn't know where it is: {lost.why}", Measured(*lost[1:]), cause=causes.LOST
            )
        if not robot.localization.heading_known:
            raise Discrepancy(
                "the heading is unknown; run ORIENT first", permanent=True, cause=causes.UNDETERMINED
            )
        self._lidar_watch.watch(robot, model.map)
        if self._local is not None:
            self._watch_local(robot)
            return
        if self._monitor is None or len(self._ahead) < 2:
            return
        sensed = self._monitor.unexpected(robot)
        found = self._monitor.obstacle(self._ahead, sensed)
        if found is None:
            self._blocked_since = None
            return
        self._blocked_since = robot.time if self._blocked_since is None else self._blocked_since
        if robot.time >= self._blocked_since + self.wait_s:
            model.obstacles = np.vstack([model.obstacles, self._monitor.kept(sensed, found[1])])
            self.evidence.points |= {"sensed": sensed, "in the way": found[1][None], "ahead": self._ahead}
            x, y = found[1]
            raise Discrepancy(
                f"an obstacle is on {self._way}, at ({x:.2f}, {y:.2f}) m",
                measured=Measured("RangeSensor", "free way ahead", found[0], WATCH_HORIZON_M, "m"),
                cause=causes.BLOCKED,
            )

    def _watch_local(self, robot: Robot) -> None:
        """Add this period's scan; raise `Discrepancy` if no route has led on for `wait_s`."""
        local = self._local
        assert local is not None
        local.sense(robot)
        if self._restores:
            self._watch_way_back(robot)
            return
        if self._blocked_since is None or robot.time < self._blocked_since + self.wait_s:
            return
        rows = local.people.people.rows
        self.evidence.points |= {"sensed": local.points, "ahead": self._ahead, "people": rows}
        local.keep()
        raise local.give_up_waiting(self._ahead)

    def _watch_way_back(self, robot: Robot) -> None:
        """Hold while an obstacle is on the way back; `restore` then takes another way."""
        assert self._local is not None
        if not way_back_blocked(self._local, robot, self._ahead):
            self._blocked_since = None
        elif self._blocked_since is None:
            self._blocked_since = robot.time

    @property
    def _way(self) -> str:
        """Return the name of the watched path in messages."""
        return "the way back" if self._restores else f"the path to {self.place}"

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the intended contacts of the arm that moves during the drive; the base intends none."""
        return model.contacts_on_the_way(self.place) if self.together else ()

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Drive back along the recorded route; wait for obstacles that are on it now.

        If the obstacles stay, and the arm did not move during the drive, take another route that is free.
        """
        self._blocked_since, self._restores = None, True
        if self._local is not None:
            self._local.keep()
        behind = np.array([[moment.pose.x, moment.pose.y] for moment in trace.moments])[::-1]
        way_back, waits = retrace(robot, start, trace, model.speed_limits), False
        while True:
            nearest = int(np.argmin(np.hypot(*(behind - (robot.pose.x, robot.pose.y)).T)))
            self._ahead = behind[nearest:]
            rolls, since = any(robot.command), self._blocked_since
            waited = not rolls and since is not None and robot.time >= since + self.wait_s
            if waited and self._local is not None and not self.together:
                self._ahead = np.empty((0, 2))
                yield from drive_back(self._local, robot, start.pose, self.wait_s)
                yield from reach_pose(robot, start.pose, held_s=HELD_RETURN_S)
                return
            if waited and self._local is not None:
                raise Discrepancy("an obstacle is on the way back", cause=causes.BLOCKED)
            waits = since is not None or (waits and rolls)
            if waits:
                brake(robot)
            elif next(way_back, self) is self:
                self._ahead = np.empty((0, 2))
                return
            yield
