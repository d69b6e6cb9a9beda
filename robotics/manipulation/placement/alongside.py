"""A base that drives straight beside a path while its arm follows it (Shin et al. 2005, figure 5b)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import FloatArray

from .placement_division import PathSegment
from .placements import Placements
from .placer import Blocked, Free, Placer

_STEP = 0.1  # [m] between the places that are tried
_FEW, _POINTS = 6, 60  # of a path, at most, that are scored: first from all places, then from the best
_BEST = 400  # places
_ROOM = 0.2  # [m] of the way between looks at the map
_EVERY = 8  # points of a path between looks for contacts
_ATTEMPTS = 40  # at ways that the arm follows, point by point


class Leg(NamedTuple):
    """Straight drive of the base during which the arm follows a part of the tool's path."""

    start: Pose2
    """world_T_base at the path's first point."""
    score: float
    """Integral of the score along that part of the path, in [m]; at most its length."""


def level_with(start: Pose2, points: FloatArray) -> FloatArray:
    """Return poses (p, 3) of a base that drives straight from `start` while its arm follows a path.

    While the arm goes from the path's first point to another point, the base drives as far as that point is
    ahead, along the base's heading. If the path leads backwards, the base drives backwards. Poses are x, y in
    [m] and heading in [rad].

    Args:
        start: world_T_base at the first point.
        points: (p, 3) points of the path in the world, in [m].
    """
    ahead = np.array([np.cos(start.theta), np.sin(start.theta)])
    along = (points[:, :2] - points[0, :2]) @ ahead
    return np.column_stack((start[:2] + along[:, None] * ahead, np.full(len(points), start.theta)))


def seen_from(bases: FloatArray, path: ToolPath) -> ToolPath:
    """Return a path as seen from a moving base: each point in the frame of the base at that point.

    Args:
        bases: (p, 3) world_T_base at each point of the path: x, y in [m], heading in [rad].
        path: path of the tool in the world.
    """
    cos, sin = np.cos(bases[:, 2]), np.sin(bases[:, 2])
    turned = np.zeros((len(bases), 3, 3))
    turned[:, 0, 0], turned[:, 0, 1], turned[:, 1, 0], turned[:, 1, 1] = cos, sin, -sin, cos
    turned[:, 2, 2] = 1.0
    off = path.points - np.column_stack((bases[:, :2], np.zeros(len(bases))))
    points, tangents, turns = (np.einsum("pij,pj->pi", turned, v) for v in (off, path.tangents, path.turns))
    return ToolPath(points, turned @ path.rotations, tangents, turns, path.lengths)


def place_alongside(
    placer: Placer, path: ToolPath, blocked: Blocked, count: int, free: Free | None = None
) -> Placements:
    """Return straight drives of the base along a path, as few as possible, each for an equal part of the
    path.

    The score at each point is computed as if the base stood still where it passes this point. The arm alone
    is therefore fast and strong enough for the work, without the base's motion.

    Args:
        placer: planner of base poses for the arm and its work.
        path: path of the tool.
        blocked: function that reports which of many base poses are blocked.
        count: maximum number of drives.
        free: function that reports whether base poses along a drive are free of contact, with the joint
            angles (1, n) at each; None: not checked.

    Returns:
        Placements whose `bases` are the beginnings of the drives.

    Raises:
        Untrackable: no such drives exist; names the first point at which the last try failed.
    """
    failed: Untrackable | None = None
    for number in range(1, count + 1):
        cuts = np.linspace(0, len(path.points) - 1, number + 1).round().astype(int).tolist()
        segments = tuple(PathSegment(n, cuts[n], cuts[n + 1]) for n in range(number))
        try:
            legs = [_leg(placer, path.part(part.first, part.last), blocked, free) for part in segments]
        except Untrackable as error:
            failed = error
            continue
        return Placements(np.array([leg.start for leg in legs]), segments, tuple(leg.score for leg in legs))
    assert failed is not None, "`count` is at least 1"
    raise failed


def _leg(placer: Placer, path: ToolPath, blocked: Blocked, free: Free | None) -> Leg:
    failed = Untrackable(0, "can't be tracked from a base that drives straight beside the seam")
    for start, score in _ranked(placer, path, blocked):
        bases = level_with(start, path.points)
        try:
            angles = placer.followed(np.zeros(3), seen_from(bases, path))
        except Untrackable as error:
            failed = error
            continue
        looked_at = zip(bases[::_EVERY], angles[::_EVERY, None], strict=True)
        if free is None or all(free(base, q) for base, q in looked_at):
            return Leg(start, score)
        failed = Untrackable(0, "or those after it can only be tracked with the robot touching something")
    raise failed


def _ranked(placer: Placer, path: ToolPath, blocked: Blocked) -> Iterator[tuple[Pose2, float]]:
    """Yield possible beginnings of a drive with their scores, the best first."""
    way = path.points[-1, :2] - path.points[0, :2]
    x, y = path.points[0, :2].tolist()
    origin = Pose2(x, y, float(np.arctan2(way[1], way[0])))
    seen = seen_from(level_with(origin, path.points), path)
    places = _grid(placer.reach)
    for points in (_FEW, _POINTS):
        some = np.unique(np.linspace(0, len(path.points) - 1, points).round().astype(int))
        thin = ToolPath(*(field[some] for field in seen))
        scores = placer.scores(places, thin)
        values = np.asarray(np.trapezoid(scores.values, thin.lengths, axis=1))
        kept = np.flatnonzero(scores.usable.all(axis=1))
        kept = kept[np.argsort(-values[kept], kind="stable")][:_BEST]
        places, values = places[kept], values[kept]
    tried = 0
    for place, value in zip(places.tolist(), values.tolist(), strict=True):
        start = origin.compose(Pose2(*place))
        if tried < _ATTEMPTS and not blocked(_spots(level_with(start, path.points))).any():
            tried += 1
            yield start, value


def _spots(bases: FloatArray) -> FloatArray:
    """Return some of the base poses (p, 3) along a drive, about `_ROOM` apart, both ends included."""
    count = 2 + int(np.hypot(*np.ptp(bases[:, :2], axis=0)) / _ROOM)
    return np.asarray(bases[np.linspace(0, len(bases) - 1, count).round().astype(int)])


def _grid(reach: float) -> FloatArray:
    """Return (b, 3) base poses around a point level with the tool, heading along the path or against it."""
    steps = np.arange(-reach, reach + _STEP, _STEP)
    x, y, turn = np.meshgrid(steps, steps, (0.0, np.pi), indexing="ij")
    return np.column_stack((x.ravel(), y.ravel(), turn.ravel()))
