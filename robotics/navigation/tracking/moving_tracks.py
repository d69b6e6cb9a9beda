"""Tracks of people and carts from scans alone: birth, assignment, death, and what counts as moving."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

from .constant_velocity import assign, correct, predict
from .scan_clusters import ScanClusters, cluster_scan
from .seen_free import PastScan, seen_free

ACCELERATION_DENSITY = 0.15  # [m²/s³] of people, who stop and turn back within half a second
POSITION_SIGMA_M = 0.11  # of a body's middle: legs swing and hide each other
FIRST_SPEED_SIGMA_M_S = 1.0
MEMORY_S = 1.6  # of scans that are asked whether a point was free
MEMORY_PERIOD_S = 0.25  # between two of them
MOVING_SPEED_M_S = 0.3  # from which a body counts as moving
STANDING_SPEED_M_S = 0.2  # a slower person is at rest
MOVING_D2 = 9.2  # squared Mahalanobis distance of its velocity from zero: 99 %
MOVED_M = 0.25  # that it has left its first place by
EVIDENCE_COUNT = 4  # scans that show it where ground was free before, until it counts as moving
EVIDENCE_SHARE = 0.5  # of its points
MAX_POSE_SIGMA_M = 0.03  # of the base, beyond which edges seem to enter free ground as the pose is corrected
ENTERED_COUNT = 2  # scans in a row that show a body where ground was free, from which it may be a person
SUSPECT_S = 0.5  # that it may be one, after the last such scan
STOOD_S = 1.0  # of rest, after which a person is an obstacle like any other
LOST_S = 0.5  # without a measurement, until a body that never moved is forgotten
PERSON_LOST_S = 1.2  # likewise for a person who may be hidden
SEEN_THROUGH_COUNT = 6  # scans that see through it, until it is forgotten
MIN_BODY_M = 0.25  # radius of a person, whatever is seen of the legs
BODY_MARGIN_M = 0.15  # around a body, within which points are its own
HISTORY_LENGTH = 24  # last positions that are kept


class BodyTrack(NamedTuple):
    """State of a tracked person or cart, with position, velocity, covariance and size."""

    number: int
    position: FloatArray
    """(2,) on the map, in [m]."""
    velocity: FloatArray
    """Velocity (2,) on the map, in [m/s]; zero at rest."""
    covariance: FloatArray
    """(4, 4) of x, y in [m] and the velocity along x and y in [m/s], on the map."""
    radius: float
    """Distance from the middle to the outermost point seen, in [m]."""
    is_moving: bool
    """False while the body is at rest."""
    stood_s: float
    """Time at rest, in [s]."""


@dataclass
class _Body:
    """A tracked body, moving or not."""

    number: int
    mean: FloatArray
    covariance: FloatArray
    radius: float
    anchor: FloatArray
    """First position (2,), or last position at rest, on the map, in [m]."""
    seen: float
    evidence: int = 0
    entered: int = 0
    """Scans in a row that showed it on ground that was free before."""
    entered_at: float = -np.inf
    """Time at which `ENTERED_COUNT` was reached last, in [s]."""
    seen_through: int = 0
    is_person: bool = False
    is_moving: bool = False
    stands_since: float = 0.0
    history: deque[FloatArray] = field(default_factory=lambda: deque(maxlen=HISTORY_LENGTH))

    def speed_d2(self) -> float:
        """Return the squared Mahalanobis distance of the velocity from zero."""
        velocity = self.mean[2:]
        return float(velocity @ np.linalg.solve(self.covariance[2:, 2:], velocity))


class TrackedScan(NamedTuple):
    """Result of tracking people and carts, with a scan's points on moving bodies, and the ground that those
    bodies left.
    """

    moving: BoolArray
    """Mask (n,) of the points on people and carts that move, or rested for less than `STOOD_S`."""
    left: FloatArray
    """Discs (k, 3), x, y on the map and radius in [m], that moving bodies left or never filled, so empty."""


class MovingTracks:
    """Tracker of all bodies in lidar scans that have the size of a person or a cart; it separates moving
    bodies from others.
    """

    def __init__(self, reach: float) -> None:
        """Track bodies up to a distance from the lidar, in [m]."""
        self._reach = reach
        self._bodies: list[_Body] = []
        self._past: deque[PastScan] = deque()
        self._number, self._time = 0, -np.inf

    @property
    def tracks(self) -> list[BodyTrack]:
        """Return the tracks of people and carts, which are bodies that move now or have moved before."""
        return [self._track_of(body) for body in self._bodies if body.is_person]

    @property
    def suspects(self) -> list[BodyTrack]:
        """Return bodies that may be people, because they appeared on free ground; their speed is not known
        yet.
        """
        since = self._time - SUSPECT_S
        return [
            self._track_of(body) for body in self._bodies if not body.is_person and body.entered_at >= since
        ]

    def _track_of(self, body: _Body) -> BodyTrack:
        return BodyTrack(
            body.number,
            body.mean[:2].copy(),
            body.mean[2:].copy() if body.is_moving else np.zeros(2),
            body.covariance.copy(),
            body.radius,
            body.is_moving,
            self._time - body.stands_since if body.is_person and not body.is_moving else 0.0,
        )

    def take(self, points: FloatArray, scan: PastScan, pose_covariance: FloatArray) -> TrackedScan:
        """Update the tracks by a scan; return the scan's points on moving bodies, and the areas of ground
        that moving bodies have left.

        Args:
            points: (n, 2) end points of beams that meet nothing shown on the map, in the map frame, in the
                order of the beams, in [m].
            scan: all beams, with their time and the pose of the lidar.
            pose_covariance: (3, 3) of the base's pose: x, y on the map in [m], heading in [rad].
        """
        sensor = np.array(scan.map_T_sensor[:2])
        near = np.hypot(*(points - sensor).T) <= self._reach
        clusters = cluster_scan(points[near], sensor)
        labels = np.full(len(points), -1, dtype=np.int64)
        labels[near] = clusters.labels
        self._predict(scan.time)
        owners = self._match(clusters, _noises(clusters.centres, sensor, pose_covariance), scan.time)
        shares = self._shares_seen_free(points, labels, owners)
        left = self._judge(owners, shares, scan)
        if _largest_variance(pose_covariance) <= MAX_POSE_SIGMA_M**2:
            for body, share in zip(owners, shares.tolist(), strict=True):
                self._note_entered(body, share, scan.time)
        self._forget(scan)
        self._remember(scan)
        return TrackedScan(self._is_at_mover(points, scan.time), left)

    def _is_at_mover(self, points: FloatArray, now: float) -> BoolArray:
        """Return which points (n, 2) lie at a body that moves or has just stopped, lone points too."""
        light = [body for body in self._bodies if self._is_light(body, now)]
        if not light or not len(points):
            return np.zeros(len(points), dtype=np.bool_)
        off = points[:, None] - np.array([item.mean[:2] for item in light])[None]
        sizes = np.array([max(item.radius, MIN_BODY_M) + BODY_MARGIN_M for item in light])
        return np.asarray((np.hypot(off[..., 0], off[..., 1]) <= sizes[None]).any(axis=1))

    def _predict(self, now: float) -> None:
        dt, self._time = max(0.0, now - self._time) if np.isfinite(self._time) else 0.0, now
        if not self._bodies or dt == 0.0:
            return
        means, covariances = predict(*self._stacked(self._bodies), dt, ACCELERATION_DENSITY)
        for body, mean, covariance in zip(self._bodies, means, covariances, strict=True):
            body.mean, body.covariance = mean, covariance

    def _match(self, clusters: ScanClusters, noises: FloatArray, now: float) -> list[_Body]:
        """Return the body of each cluster, after correcting it; new ones for those that fit none."""
        owners: dict[int, _Body] = {}
        if self._bodies:
            means, covariances = self._stacked(self._bodies)
            pairs = assign(means, covariances, clusters.centres, noises)
            if pairs:
                rows, columns = (list(item) for item in zip(*pairs, strict=True))
                found = correct(means[rows], covariances[rows], clusters.centres[columns], noises[columns])
                for row, column, mean, covariance in zip(rows, columns, *found, strict=True):
                    body = owners[column] = self._bodies[row]
                    body.mean, body.covariance = mean, covariance
                    body.radius += 0.2 * (float(clusters.radii[column]) - body.radius)
                    body.seen, body.seen_through = now, 0
        return [
            owners.get(index) or self._born(clusters, index, noises[index], now)
            for index in range(len(clusters.centres))
        ]

    def _born(self, clusters: ScanClusters, index: int, noise: FloatArray, now: float) -> _Body:
        self._number += 1
        covariance = np.zeros((4, 4))
        covariance[:2, :2], covariance[2:, 2:] = noise, FIRST_SPEED_SIGMA_M_S**2 * np.eye(2)
        centre = clusters.centres[index]
        mean = np.append(centre, (0.0, 0.0))
        body = _Body(self._number, mean, covariance, float(clusters.radii[index]), centre.copy(), now)
        self._bodies.append(body)
        return body

    def _shares_seen_free(self, points: FloatArray, labels: IntArray, owners: list[_Body]) -> FloatArray:
        """Return the share (k,) of each cluster's points that are where an earlier scan saw free ground.

        For a person at rest, scans count from when the rest began.
        """
        owned, count = labels >= 0, len(owners)
        free = np.zeros(int(owned.sum()), dtype=np.bool_)
        stands = [
            owner.stands_since if owner.is_person and not owner.is_moving else -np.inf for owner in owners
        ]
        since = np.array(stands)[labels[owned]]
        for past in self._past:
            free |= seen_free(points[owned], past, self._reach) & (past.time >= since)
        sizes = np.bincount(labels[owned], minlength=count)
        return np.asarray(np.bincount(labels[owned], free, minlength=count) / np.maximum(sizes, 1))

    def _judge(self, owners: list[_Body], shares: FloatArray, scan: PastScan) -> FloatArray:
        """Decide who moves; return the discs (k, 3) that newly moving bodies have left behind."""
        left: list[FloatArray] = []
        vacated = seen_free(np.array([owner.anchor for owner in owners]).reshape(-1, 2), scan, self._reach)
        for body, share, is_vacated in zip(owners, shares.tolist(), vacated.tolist(), strict=True):
            shows = share >= EVIDENCE_SHARE or is_vacated
            body.evidence = min(body.evidence + 1, 2 * EVIDENCE_COUNT) if shows else max(0, body.evidence - 1)
            body.history.append(body.mean[:2].copy())
            speed = float(np.hypot(*body.mean[2:]))
            if body.is_moving:
                if speed < STANDING_SPEED_M_S:
                    body.is_moving, body.stands_since = False, scan.time
                    body.anchor = body.mean[:2].copy()
                continue
            moved = float(np.hypot(*(body.mean[:2] - body.anchor))) > MOVED_M
            fast = speed > MOVING_SPEED_M_S and body.speed_d2() > MOVING_D2
            if moved and fast and body.evidence >= EVIDENCE_COUNT:
                body.is_moving = body.is_person = True
                size = max(body.radius, MIN_BODY_M) + BODY_MARGIN_M
                left += [np.append(place, size) for place in (body.anchor, *body.history)]
        return np.array(left).reshape(-1, 3)

    @staticmethod
    def _note_entered(body: _Body, share: float, now: float) -> None:
        """Record whether a body is on ground that was free: a resting person has left, other bodies are
        people.
        """
        body.entered = body.entered + 1 if share >= EVIDENCE_SHARE else 0
        if body.entered < ENTERED_COUNT:
            return
        body.entered_at = now
        body.is_person = body.is_person or body.entered >= EVIDENCE_COUNT
        if body.is_person and not body.is_moving:
            body.stands_since = now

    def _forget(self, scan: PastScan) -> None:
        """Drop bodies that were not seen for long, or that beams pass through."""
        missing = [item for item in self._bodies if item.seen < scan.time]
        through = seen_free(np.array([item.mean[:2] for item in missing]).reshape(-1, 2), scan, self._reach)
        for body, is_through in zip(missing, through.tolist(), strict=True):
            body.seen_through += int(is_through)
        self._bodies = [
            item
            for item in self._bodies
            if item.seen_through < SEEN_THROUGH_COUNT
            and scan.time - item.seen <= (PERSON_LOST_S if item.is_person else LOST_S)
        ]

    def _remember(self, scan: PastScan) -> None:
        if not self._past or scan.time >= self._past[-1].time + MEMORY_PERIOD_S - 1e-6:
            self._past.append(scan)
        while self._past[0].time < scan.time - MEMORY_S:
            self._past.popleft()

    @staticmethod
    def _is_light(body: _Body, now: float) -> bool:
        """Return whether a body is not a lasting obstacle: it moves, or has only just come to rest."""
        return body.is_moving or (body.is_person and now - body.stands_since < STOOD_S)

    @staticmethod
    def _stacked(bodies: list[_Body]) -> tuple[FloatArray, FloatArray]:
        return np.array([body.mean for body in bodies]), np.array([body.covariance for body in bodies])


def _noises(centres: FloatArray, sensor: FloatArray, pose_covariance: FloatArray) -> FloatArray:
    """Return the covariances (k, 2, 2) of measured middles: the body's, and the pose's at their distance."""
    rays = centres - sensor
    across = np.stack([-rays[:, 1], rays[:, 0]], axis=1)
    turned = across[:, :, None] * across[:, None, :] * pose_covariance[2, 2]
    return np.asarray(POSITION_SIGMA_M**2 * np.eye(2) + pose_covariance[:2, :2] + turned)


def _largest_variance(pose_covariance: FloatArray) -> float:
    """Return the variance of a position in its worst direction, in [m²], by the covariance (3, 3)."""
    (xx, _, _), (xy, yy, _), _ = pose_covariance.tolist()
    return float(0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy))
