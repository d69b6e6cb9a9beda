"""Driving around what no map shows: a layer of what is sensed, and a new route when one is needed."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.robot.beside import at_rest, in_steps
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.bumps import avoided_points
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.maps.scan_layer import ScanLayer
from handcart.robotics.navigation.routes.centring import centred
from handcart.robotics.navigation.routes.far_replanning import FarReplanner
from handcart.robotics.navigation.routes.replanning import Replanner, RouteLook, free_length
from handcart.robotics.numerics.arrays import FloatArray

from .backing_off import BackingOff, PinnedWatch
from .driving import no_way, plan_drive
from .near_map import NearMap
from .people_watch import PeopleWatch

EXPLAINED_M = 0.08  # from anything on the map: pose error, noise and half a cell together
MAX_EXPLAINED_M = 0.3  # the same where the pose is uncertain
LOOK_PERIOD_S = 0.2  # between two looks whether the route is free
BETTER_PERIOD_S = 1.0  # between two looks for a better one
LEAD_S = 0.3  # of motion along the old route that stays the beginning of a new one
LEAD_SPEED_M_S = 0.3  # from which it stays
HOLD_DISTANCE_M = 1.0  # before what no way leads around, at which the base holds
OLD_CELLS_S = 20.0  # after which what nothing looked at is dropped, if it closes all ways
MIN_SHIFT_M = 0.006  # to the middle of a narrow place, from which a route is changed for it
PLANNING_S = 0.2  # simulated, of a plan while the base holds
NEARER_M = 0.1  # by which the rest of the way has to shrink
NEARER_TIMEOUT_S = 60.0  # within which it has to
NEARER_FACTOR = 3.0  # of the time that the rest takes at top speed, if that is more


class LocalReplanning:
    """Repeated planning of the route in a drive, around people and obstacles that the map does not show."""

    def __init__(self, robot: Robot, model: ModelView, name: str, place: Place | None = None) -> None:
        """Begin a drive to the place `name`, or to `place` on the way, with what earlier drives sensed."""
        self._model, self._name = model, name
        self._place: Place = place or model.places[name]
        self._goal = self._place.pose
        self._front = self._place.front if self._place.docks else None
        lidar = robot.spec.range_sensor
        reach = 0.0 if lidar is None else lidar.reach_m
        self._near = NearMap(model.map, model.sensed_cells, reach, robot.pose)
        limits = robot.drive_limits
        self._top, self._shape, self._sensed = limits.speed, robot.spec.footprint_shape, np.empty((0, 2))
        self._replanner = Replanner(robot.spec.footprint_shape, limits.speed, model.speed_limits)
        self._far: FarReplanner | None = None
        if not self._near.is_whole:
            radius, half = robot.spec.footprint_radius_m, self._near.half
            self._far = FarReplanner(model.map, self._shape, radius, half, limits.speed, model.speed_limits)
        self.people = PeopleWatch(robot)
        self.speed_limit = np.inf
        """Speed along the route that yields to people, in [m/s]."""
        self._job: Generator[None, None, RouteLook] | None = None
        self._next_look = self._next_better = robot.time
        self.blocked_since: float | None = None
        """Time since which the base holds because no way leads on, in [s]; None while one does."""
        self._look: RouteLook | None = None
        self._tries_less_room = False
        """True while no way was found with the last distance to people, and one with less is to be tried."""
        self._pinned, self._backing_off = PinnedWatch(robot.pose), BackingOff()
        self._nearest, self._nearer_at = np.inf, robot.time

    @property
    def holds(self) -> bool:
        """True if the base has to wait at rest, because its goal has no route or a person has to pass."""
        return self.blocked_since is not None or self.speed_limit <= 0.0

    @property
    def waits_since(self) -> float | None:
        """Time since which the base has waited for an obstacle or people, in [s]; None if the base does not
        wait.
        """
        since = [item for item in (self.blocked_since, self.people.waits_since) if item is not None]
        return min(since, default=None)

    @property
    def points(self) -> FloatArray:
        """Points (n, 2) of sensed obstacles that the map does not show, in map coordinates, in [m]."""
        return self._layer.points

    @property
    def _layer(self) -> ScanLayer:
        return self._near.layer

    def sense(self, robot: Robot) -> None:
        """Record people and obstacles in the current scan of the lidar.

        Only people are recorded while scans contradict the wheels, or the lidar repeats an old scan.
        """
        self._near.follow(robot.pose)
        scan = robot.range_sensor.scan()
        map_T_sensor = robot.pose.compose(scan.base_T_sensor)
        ranges = np.where(scan.blind(), np.nan, scan.ranges) if len(scan.validity) else scan.ranges
        explained = np.zeros(len(ranges), dtype=np.bool_)
        hit = np.isfinite(scan.ranges)
        margin = EXPLAINED_M
        if robot.localization.dead_reckoned:
            margin = min(MAX_EXPLAINED_M, max(margin, 3.0 * robot.localization.sigma[0]))
        self._sensed = robot.pose.apply(scan.points())
        explained[hit] = self._near.field.read(self._sensed) <= margin
        moving, left = self.people.take(robot, scan, ranges, explained)
        if not robot.localization.held_base.is_settled or robot.localization.stale_s > 0.0:
            return
        self._layer.erase(left)
        self._layer.take(map_T_sensor, scan.angles, ranges, explained | moving, robot.time)

    def keep(self) -> None:
        """Store the obstacle cells sensed on this drive in the world model, without those of people."""
        self._model.sensed_cells = self.people.without_people(self._near.cells())

    def plan(self, robot: Robot) -> Generator[None, None, RouteLook]:
        """Plan a route from the base's pose to the drive's goal, and return it; the base stands still until a
        route is found.

        Raises:
            Discrepancy: no route leads to the goal.
        """
        self.sense(robot)
        if self._near.is_whole:
            yield from self._check_map(robot)
        detour = self._model.detour
        route = detour.points if detour is not None and detour.goal == self._name else None
        look = yield from self.planned(robot, route, robot.period)
        if look.kind == "none":
            if not self._near.is_whole:
                yield from self._check_map(robot)
            raise self._no_way()
        self._look, self._nearest = look, np.inf
        self._nearer_at = robot.time
        return look

    def _check_map(self, robot: Robot) -> Generator[None, None, None]:
        """Raise `Discrepancy` with the reason if no way leads to the place on the map alone."""
        lasting = yield from robot.compute(plan_drive, robot, self._model, self._place, False)
        if lasting.route is None:
            raise no_way(self._name, lasting)

    def update(self, robot: Robot, tracker: PathTracker) -> None:
        """Plan a new route and change to it if the present route is blocked or the new one is shorter.

        The method is called once a period.
        """
        self.speed_limit = self.people.limit(robot, tracker)
        self._note_progress(robot, tracker)
        if self._job is not None:
            self._advance(self._job, robot, tracker)
            return
        if tracker.closing or robot.time < self._next_look:
            return
        better = robot.time >= self._next_better
        self._next_look = robot.time + LOOK_PERIOD_S
        if better:
            self._next_better = robot.time + BETTER_PERIOD_S
        speed = abs(robot.command.along)
        lead = LEAD_S * speed if speed > LEAD_SPEED_M_S else 0.0
        if better and not self._tries_less_room:  # looks that take longer than `BETTER_PERIOD_S` end, too
            self.people.try_all_room()
        arguments = robot.pose, tracker.ahead, self._avoided(robot), robot.time, lead, better
        self._job = in_steps(self._answering(*arguments), robot.backend.simulated)
        self._advance(self._job, robot, tracker)

    def _advance(self, job: Generator[None, None, RouteLook], robot: Robot, tracker: PathTracker) -> None:
        """Continue planning for a period; apply the result once it is done, on a real robot maybe at once."""
        try:
            next(job)
        except StopIteration as end:
            self._job = None
            self._apply(end.value, robot, tracker)

    def planned(
        self, robot: Robot, route: FloatArray | None = None, takes: float = PLANNING_S
    ) -> Generator[None, None, RouteLook]:
        """Plan a route to the goal while the base is stopped; the `kind` of the result is "none" if there is
        no route.

        If sensed obstacles close all routes, those that the lidar has last hit more than `OLD_CELLS_S` ago
        are forgotten.

        Args:
            robot: the robot.
            route: (n, 2) points on the map, in [m], of an earlier route, which is kept if it is free; None: a
                new route is planned.
            takes: simulated time that planning takes, in [s].
        """
        look = yield from self._least_room(robot, route, takes)
        if look.kind == "none" and self._near.forget(robot.time - OLD_CELLS_S):
            look = yield from self._least_room(robot, route, PLANNING_S)
        return look

    def _least_room(
        self, robot: Robot, route: FloatArray | None, takes: float
    ) -> Generator[None, None, RouteLook]:
        """Plan while the base holds, with ever less distance to people until a route is found; return it."""
        self.people.try_all_room()
        while True:
            steps = self._answering(robot.pose, route, self._avoided(robot), robot.time)
            look = yield from at_rest(steps, robot, robot.backend.simulated, takes)
            if look.kind != "none" or self.people.is_last_attempt:
                return look
            self.people.try_less_room()

    def _answering(
        self,
        pose: Pose2,
        route: FloatArray | None,
        avoided: FloatArray,
        time: float,
        lead: float = 0.0,
        better: bool = True,
    ) -> Generator[None, None, RouteLook]:
        """Check or plan the route, yielding about once for each graph; return the result."""
        grid = self.people.drawn_on(self._layer.merged().with_points(avoided), pose)
        if self._far is None:
            look = yield from self._replanner.looking(
                grid, pose, self._goal, self._front, route, lead, better
            )
        else:
            sensed = np.vstack([self._near.all_points(), avoided])
            looking = self._far.looking(
                grid, sensed, pose, self._goal, self._front, route, lead, better, time
            )
            look = yield from looking
        if self._shape.is_disc or look.kind == "none":
            return look
        points, shift = centred(look.points, self._shape, self._sensed)
        return look._replace(kind="new", points=points) if shift > MIN_SHIFT_M else look

    def _avoided(self, robot: Robot) -> FloatArray:
        return avoided_points(robot, self._model)

    def _apply(self, look: RouteLook, robot: Robot, tracker: PathTracker) -> None:
        self._tries_less_room = look.kind == "none" and not self.people.is_last_attempt
        if self._tries_less_room:
            self.people.try_less_room()
            self._next_look = robot.time
            return
        self._look = look
        if look.kind == "none" and self._near.forget(robot.time - OLD_CELLS_S):
            self._next_look = self._next_better = robot.time
        if look.kind == "new":
            tracker.reroute(look.points, look.speeds)
        else:
            tracker.limit_speeds(look.speeds)
        if look.kind == "none" and look.free < HOLD_DISTANCE_M + robot.stopping_distance:
            self.blocked_since = robot.time if self.blocked_since is None else self.blocked_since
        else:
            self.blocked_since = None

    def _note_progress(self, robot: Robot, tracker: PathTracker) -> None:
        """Raise `Discrepancy` if the rest of the way has not shrunk for long."""
        waits, nearer = self.waits_since is not None, tracker.remaining < self._nearest - NEARER_M
        if nearer or waits:
            self._nearest, self._nearer_at = min(self._nearest, tracker.remaining), robot.time
        if nearer:
            self._backing_off.tries = 0
        patience = max(NEARER_TIMEOUT_S, NEARER_FACTOR * tracker.remaining / self._top)
        if robot.time > self._nearer_at + patience:
            since = robot.time - self._nearer_at
            late = Measured("Base", "time without getting nearer", since, patience, "s")
            raise Discrepancy(
                f"the base doesn't get nearer to {self._name}", measured=late, cause=causes.NO_PROGRESS
            )
        self._pinned.note(robot, waits)
        if self._pinned.is_held and robot.held is not None and robot.held.shown_by == "scan":
            self._layer.add(np.array([[robot.held.x, robot.held.y]]), robot.time)

    def pinned(self, robot: Robot) -> bool:
        """Return whether the base should back off, because a near obstacle has stopped it for `PINNED_S`."""
        pinned = self._pinned.is_pinned and self.waits_since is None
        return pinned and self._backing_off.may_try

    def back_off(self, robot: Robot, tracker: PathTracker) -> Generator[None, None, None]:
        """Drive straight away from the obstacle before which the base was stopped, and plan a new route."""
        held = robot.held
        if held is not None and held.shown_by == "scan":
            self._layer.add(np.array([[held.x, held.y]]), robot.time)
        yield from self._backing_off.drive(robot, tracker.reverse)
        tracker.stopped()
        self._job = None
        look = yield from self.planned(robot)
        self._pinned.restart(robot.pose)
        if look.kind == "new":
            self._apply(look, robot, tracker)

    def command(self, robot: Robot, tracker: PathTracker) -> tuple[float, ...]:
        """Return the base's speed command along the route, or a command to stop while it waits for a free
        route.
        """
        if self.holds:
            return tracker.hold(robot.pose, robot.period)
        return tracker.command(robot.pose, robot.period, self.speed_limit)

    def free_length(self, ahead: FloatArray, least: float) -> float | None:
        """Return the length, in [m], over which a route is free of sensed obstacles; None if the complete
        route is free.

        Args:
            ahead: (n, 2) points of the rest of the route, on the map, in [m].
            least: distance to sensed points that counts as free, in [m].
        """
        length, obstacle = free_length(self._layer.merged(), ahead, least)
        return None if obstacle is None else length

    def turn_to(self, goal: Pose2, robot: Robot) -> None:
        """Replace the goal of the drive by another pose map_T_base, to which further routes lead."""
        self._goal, self._front, self._job, self.blocked_since = goal, None, None, None
        self._nearest, self._nearer_at = np.inf, robot.time

    def give_up_waiting(self, ahead: FloatArray) -> Discrepancy:
        """Return the error that ends the drive: an obstacle is on the route, and no other route leads to the
        goal.

        Args:
            ahead: (n, 2) points of the rest of the route, on the map, in [m].
        """
        x, y = self._nearest_to_route(ahead)
        if self.people.waits_since is not None or self.people.is_person(x, y):
            return self.people.blocked(f"the path to {self._name}", (x, y))
        free = 0.0 if self._look is None else self._look.free
        return Discrepancy(
            f"an obstacle is on the path to {self._name}, at ({x:.2f}, {y:.2f}) m, "
            "and no other way leads there",
            measured=Measured("RangeSensor", "free way ahead", free, HOLD_DISTANCE_M, "m"),
            cause=causes.BLOCKED,
        )

    def _nearest_to_route(self, ahead: FloatArray) -> tuple[float, float]:
        """Return the sensed point on the map nearest to where the route `ahead` isn't free, in [m]."""
        there = None if self._look is None else self._look.obstacle
        x, y = there if there is not None else (ahead[-1].tolist() if len(ahead) else self._goal[:2])
        points = self._layer.points
        if not len(points):
            return x, y
        nearest = points[int(np.argmin(np.hypot(*(points - (x, y)).T)))]
        return float(nearest[0]), float(nearest[1])

    def _no_way(self) -> Discrepancy:
        return Discrepancy(
            f"no way leads to {self._name} past what was sensed",
            measured=Measured("RangeSensor", "points sensed that are not on the map", len(self.points)),
            cause=causes.NO_ROUTE,
        )
