"""People and carts among the beams of a lidar: where they go, and how a drive yields to them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.tracking.moving_tracks import STOOD_S, MovingTracks, TrackedScan
from handcart.robotics.navigation.tracking.people import People, with_people
from handcart.robotics.navigation.tracking.seen_free import PastScan
from handcart.robotics.navigation.tracking.yielding import yielding_speed
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

REACH_M = 6.0  # from the lidar, within which people are tracked
LESS_ROOM_RATIO = 0.4  # of the stated distance, where no way keeps it
WAITING_MOTION_M = 0.1  # from where it began to wait, beyond which the base gets on
WAITING_PAUSE_S = 1.0  # between two stops that count as one wait
NEAR_PERSON_M = 0.3  # from a person's body, within which what was sensed is the person


class BeamOrder(NamedTuple):
    """Indices that sort a lidar's beams by angle, and the sorted angles, rounded to equal spacing."""

    order: IntArray
    angles: FloatArray
    """(n,) ascending, in [rad]."""


class PeopleWatch:
    """Tracking of people during one drive, and decisions on slowing down and planning around them."""

    def __init__(self, robot: Robot) -> None:
        """Begin before any person is seen."""
        self._keep, self._radius = robot.spec.drive.person_distance_m, robot.spec.footprint_radius_m
        self._tracks = MovingTracks(REACH_M)
        self._beams: BeamOrder | None = None
        self._level = 0
        self._taken_at = self._waited_at = -np.inf
        self._waits_at = robot.pose
        self.people = People.of(())
        """All persons as of the last scan."""
        self.waits_since: float | None = None
        """Time since which the base waits for a person, in [s]; None while it does not."""

    def take(self, robot: Robot, scan: Scan, ranges: FloatArray, explained: BoolArray) -> TrackedScan:
        """Track the people in a scan, and let the base keep its distance from them in this period.

        Args:
            robot: robot with the lidar.
            scan: scan of this period.
            ranges: (n,) measured ranges in [m], in the order of the scan; NaN for blind beams.
            explained: (n,) True for beams that end at obstacles on the map.

        Returns:
            Mask (n,) of the beams that end at moving people, and discs (k, 3) of floor that these people have
            left, so that it is free: x, y and radius on the map, in [m]. A second call in a period reports no
            people and no discs.
        """
        moving = np.zeros(len(ranges), dtype=np.bool_)
        if robot.time <= self._taken_at or len(ranges) < 3:
            return TrackedScan(moving, np.empty((0, 3)))
        self._taken_at = robot.time
        if not robot.localization.held_base.is_settled or robot.localization.stale_s > 0.0:
            return self._unsettled(robot, moving)
        beams = self._ordered(scan.angles)
        sensor = robot.pose.compose(scan.base_T_sensor)
        chosen = beams.order[(np.isfinite(scan.ranges) & ~explained)[beams.order]]
        points = _ends(sensor, scan.angles[chosen], scan.ranges[chosen])
        past = PastScan(robot.time, sensor, beams.angles, ranges[beams.order])
        tracked = self._tracks.take(points, past, robot.localization.covariance)
        moving[chosen] = tracked.moving
        tracks, suspects = self._tracks.tracks, self._tracks.suspects
        self.people = People.of(tracks)
        robot.people.show(robot.time, tracks, robot.localization, suspects)
        robot.base.keep_off_people(People.of([*tracks, *suspects]))
        return TrackedScan(moving, tracked.left)

    def _unsettled(self, robot: Robot, moving: BoolArray) -> TrackedScan:
        """Ignore people in a scan whose pose is in doubt: walls beside the map would count as people."""
        if robot.localization.held_base.searches:
            self._tracks, self.people = MovingTracks(REACH_M), People.of(())
        robot.base.keep_off_people(self.people)
        return TrackedScan(moving, np.empty((0, 3)))

    def _ordered(self, angles: FloatArray) -> BeamOrder:
        """Return the beams in evenly spaced angles to the left; if the scan's angles are uneven, the nearest
        beams.
        """
        if self._beams is None or len(self._beams.order) != len(angles):
            order = np.argsort(angles, kind="stable")
            even = np.linspace(angles[order[0]], angles[order[-1]], len(angles))
            if np.abs(angles[order] - even).max() > 0.25 * abs(even[1] - even[0]):
                order = order[np.abs(angles[order][None] - even[:, None]).argmin(axis=1)]
            self._beams = BeamOrder(order, even)
        return self._beams

    @property
    def sees_people(self) -> bool:
        """True if the last scan shows people, or if the base waits for a person who is out of sight now."""
        return self.waits_since is not None or len(self.people.radii) > 0

    @property
    def _walking(self) -> People:
        """People who move, or have only just stopped; all others are obstacles."""
        return self.people.chosen(self.people.stood_s < STOOD_S)

    def limit(self, robot: Robot, tracker: PathTracker) -> float:
        """Return the speed along the tracker's route that yields to people, in [m/s]; 0 means to wait.

        It is the top speed if nobody is near. The method also updates `waits_since`, the time since which the
        base waits for a person.
        """
        most, walking = robot.drive_limits.speed, self._walking
        if len(walking.radii):
            most = yielding_speed(tracker.ahead, most, walking, self._radius, self._keep)
        self.note_waiting(robot, most <= 0.0)
        return most

    def note_waiting(self, robot: Robot, waits: bool) -> None:
        """Update `waits_since`, the time since which the base waits for a person; called once a period.

        Interruptions of up to `WAITING_PAUSE_S` count as waiting, unless the base moves by more than
        `WAITING_MOTION_M`.

        Args:
            robot: the robot.
            waits: True if the base waits in this period.
        """
        if waits or robot.base.yields:
            self._waited_at = robot.time
            if self.waits_since is None:
                self.waits_since, self._waits_at = robot.time, robot.pose
        elif self.waits_since is not None:
            moved = robot.pose.distance(self._waits_at) > WAITING_MOTION_M
            if moved or robot.time > self._waited_at + WAITING_PAUSE_S:
                self.waits_since = None

    def blocked(self, way: str, at: tuple[float, float]) -> Discrepancy:
        """Return a `Discrepancy`, because a person is on a route and does not leave.

        Args:
            way: name of the route in the message.
            at: point of the route near the person, x and y on the map in [m].
        """
        x, y = at
        away = np.inf
        if len(self.people.radii):
            off = np.hypot(*(self.people.positions - at).T)
            nearest = int(np.argmin(off))
            (x, y), away = self.people.positions[nearest].tolist(), float(off[nearest])
        return Discrepancy(
            f"a person is on {way}, at ({x:.2f}, {y:.2f}) m, and does not leave",
            measured=Measured("RangeSensor", "from the person to the way", away, self._keep, "m"),
            cause=causes.BLOCKED,
        )

    def drawn_on(self, grid: GridMap, pose: Pose2) -> GridMap:
        """Return a map for planning a route, in which people and some distance around them are occupied.

        The distance is smaller if no route was found at the full distance. If none was found at the smaller
        distance either, the map is returned unchanged.

        Args:
            grid: the map.
            pose: pose of the base, map_T_base.
        """
        if self.is_last_attempt:
            return grid
        keep = self._keep * (1.0 if self._level == 0 else LESS_ROOM_RATIO)
        here = np.array(pose[:2])
        return with_people(grid, self.people, here, self._radius, keep)

    @property
    def is_last_attempt(self) -> bool:
        """True if routes are planned without regard to people, as none is seen or no route avoids them."""
        return self._level > 1 or not len(self.people.radii)

    def try_less_room(self) -> None:
        """Let the next route be planned with less distance to people than in the robot's file.

        If it is called again before the full distance is restored (`try_all_room`), people are ignored in
        planning; the base still waits for them.
        """
        self._level += 1

    def try_all_room(self) -> None:
        """Let the next route be planned with the full distance to people that the robot's file states. This
        ends the effect of `try_less_room`.
        """
        self._level = 0

    def is_person(self, x: float, y: float) -> bool:
        """Return whether a point on the map, in [m], is within `NEAR_PERSON_M` of a detected person's
        body.
        """
        away = np.hypot(*(self.people.positions - (x, y)).T) - self.people.radii
        return bool((away < NEAR_PERSON_M).any())

    def without_people(self, cells: FloatArray) -> FloatArray:
        """Return the rows (n, k) whose first two columns, x and y on the map in [m], are at least
        `NEAR_PERSON_M` from every person's body.
        """
        if not len(cells) or not len(self.people.radii):
            return cells
        off = cells[:, None, :2] - self.people.positions[None]
        away = np.hypot(off[..., 0], off[..., 1]) - self.people.radii[None]
        return np.asarray(cells[(away >= NEAR_PERSON_M).all(axis=1)])


def _ends(map_T_sensor: Pose2, angles: FloatArray, ranges: FloatArray) -> FloatArray:
    """Return the ends (n, 2) of beams on the map, in [m], by angles (n,) in [rad] and ranges (n,) in [m]."""
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    return np.asarray(map_T_sensor.apply(ranges[:, None] * rays))
