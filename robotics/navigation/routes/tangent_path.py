"""Shortest ways of a car past round obstacles: arcs and the straight lines that touch them.

A shortest path among discs consists of common tangents and of arcs round the discs. With circles no tighter
than the car's turning circle, and with the two turning circles at either end, all of it can be steered
(Dubins, 1957). Without them, from point to point, it is the detour that no vehicle can shorten.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

TOUCH_TOLERANCE_M = 1e-6  # [m] that a tangent may seem to be inside the disc it touches
CIRCLE_DIRECTIONS_RAD = (
    -1.4,
    -0.7,
    0.0,
    0.7,
    1.4,
)  # [rad] beside straight aside: where a wide circle lies on a small disc
MANY_LEANS = tuple(0.25 * k for k in range(-6, 7))  # where those few give a long way
BACKING_LENGTHS_M = (0.0, 0.25, 0.5, 0.75, 1.5, 2.25, 3.0)  # [m] that may be driven backwards at either end
LONG_PATH_RATIO = 1.05  # of the detour that no vehicle can shorten: shorter, and backing isn't tried
PATH_SPACING_M = 0.05  # [m] between points of a path


class CarPath(NamedTuple):
    """Path that a car can drive forwards, and the distances that it drives backwards before and after the
    path.
    """

    poses: FloatArray
    """(n, 3) x, y in [m], heading in [rad], in the frame of start and obstacles."""
    curvatures: FloatArray
    """(n,) in [1/m], positive to the left, of the piece that ends with the point."""
    length: float
    """Total length in [m], backing included."""
    back_before: float = 0.0
    """Distance driven straight backwards before the path, in [m]; `poses` begin where that ends."""
    back_after: float = 0.0
    """Distance driven backwards after the path, to the goal, in [m]."""


class _Circle(NamedTuple):
    """Circle that is driven around in one direction only."""

    x: float
    y: float
    radius: float
    sense: float  # 1 anticlockwise, -1 clockwise


class _Line(NamedTuple):
    """A straight line tangent to two circles."""

    begin: int
    end: int
    start: tuple[float, float]
    heading: float
    length: float


def car_path(start: Pose2, goal: Pose2, discs: FloatArray, radius: float) -> CarPath | None:
    """Return a short path of a car past discs; None if none is found.

    If there is no path forwards, or only one with a full circle, the car may also drive backwards before the
    path, or drive past the goal and then backwards to it.

    Args:
        start: world_T_base at the start.
        goal: world_T_base to reach, with its heading.
        discs: (n, 3) x, y and radius of obstacles in the world, in [m], grown by the room that the car's body
            needs to either side.
        radius: radius of the car's turning circle, in [m].
    """
    discs = np.asarray(discs, dtype=np.float64).reshape(-1, 3)
    best = _forward(start, goal, discs, radius)
    least = shortest_detour(np.array(start[:2]), np.array(goal[:2]), discs)
    if not math.isinf(least) and (best is None or best.length > LONG_PATH_RATIO * least):
        other = _forward(start, goal, discs, radius, MANY_LEANS)
        best = min((path for path in (best, other) if path is not None), key=_length, default=None)
    for before, after in sorted(((b, a) for b in BACKING_LENGTHS_M for a in BACKING_LENGTHS_M), key=sum)[1:]:
        if math.isinf(least) or (
            best is not None and best.length <= max(LONG_PATH_RATIO * least, least + before + after)
        ):
            break
        begin, end = start.compose(Pose2(-before, 0.0, 0.0)), goal.compose(Pose2(after, 0.0, 0.0))
        straight = np.array([[*start[:2], *begin[:2]], [*goal[:2], *end[:2]]])
        found = (
            _forward(begin, end, discs, radius)
            if _lines_free(straight[:, :2], straight[:, 2:], discs).all()
            else None
        )
        if found is not None and (best is None or found.length + before + after < best.length):
            best = found._replace(length=found.length + before + after, back_before=before, back_after=after)
    return best


def _length(path: CarPath) -> float:
    return path.length


def _forward(
    start: Pose2,
    goal: Pose2,
    discs: FloatArray,
    radius: float,
    leans: Sequence[float] = CIRCLE_DIRECTIONS_RAD,
) -> CarPath | None:
    """Return the shortest path past discs without backing, or None."""
    ends = [*_turning(start, radius), *_turning(goal, radius)]
    aside = math.atan2(goal.y - start.y, goal.x - start.x) + math.pi / 2.0
    circles = ends + [circle for disc in discs for circle in _round(disc, radius, aside, leans)]
    return _shortest(circles, (start.theta, goal.theta), discs)


def shortest_detour(start: FloatArray, goal: FloatArray, discs: FloatArray) -> float:
    """Return the length, in [m], of the shortest path between two points past discs; infinity if there is
    none.

    Args:
        start: (2,) first point, in the frame of the discs, in [m].
        goal: (2,) last point, in the frame of the discs, in [m].
        discs: (n, 3) x, y and radius, in [m].
    """
    discs = np.asarray(discs, dtype=np.float64).reshape(-1, 3)
    ends = [_Circle(float(x), float(y), 0.0, sense) for x, y in (start, goal) for sense in (1.0, -1.0)]
    circles = ends + [_Circle(x, y, own, sense) for x, y, own in discs.tolist() for sense in (1.0, -1.0)]
    found = _shortest(circles, None, discs)
    return math.inf if found is None else found.length


def _turning(pose: Pose2, radius: float) -> list[_Circle]:
    """Return the two circles that a car at a pose can drive."""
    left = -math.sin(pose.theta), math.cos(pose.theta)
    return [
        _Circle(pose.x + s * radius * left[0], pose.y + s * radius * left[1], radius, s) for s in (1.0, -1.0)
    ]


def _round(disc: FloatArray, radius: float, aside: float, leans: Sequence[float]) -> list[_Circle]:
    """Return the circles round a disc on which a car may pass it, one or more for each direction of turning.

    Around a disc that is smaller than the car's turning circle, these are turning circles that contain and
    touch it.

    Args:
        disc: (3,) x, y and radius, in [m].
        radius: radius of the turning circle, in [m].
        aside: direction to the left of the line from start to goal, in [rad].
        leans: turns from there, or from the opposite direction, to where a turning circle touches the disc,
            in [rad].
    """
    x, y, own = disc.tolist()
    if own >= radius:
        return [_Circle(x, y, own, sense) for sense in (1.0, -1.0)]
    found = []
    for sense in (1.0, -1.0):
        for lean in leans:
            away = aside + lean + (math.pi if sense > 0.0 else 0.0)
            back = own - radius
            found.append(_Circle(x + back * math.cos(away), y + back * math.sin(away), radius, sense))
    return found


def _shortest(
    circles: list[_Circle], headings: tuple[float, float] | None, discs: FloatArray
) -> CarPath | None:
    """Dijkstra's search over tangents; circles 0 and 1 are the start's, 2 and 3 the goal's."""
    lines = _free_lines(circles, discs)
    leaving: dict[int, list[int]] = {}
    for number, line in enumerate(lines):
        leaving.setdefault(line.begin, []).append(number)
    queue: list[tuple[float, int, int]] = []  # length so far, the line driven last, the circle that ends at
    cost: dict[int, float] = {}
    before: dict[int, int] = {}
    done: set[int] = set()

    def onward(length: float, came: int, circle: int, heading: float | None) -> None:
        for number in leaving.get(circle, []):
            turn = _turn(circles[circle], heading, lines[number].heading)
            total = length + circles[circle].radius * turn + lines[number].length
            if number in done or total >= cost.get(number, math.inf):
                continue
            if heading is None or _arc_free(circles[circle], heading, turn, discs):
                cost[number], before[number] = total, came
                heapq.heappush(queue, (total, number, came))

    for circle in (0, 1):
        onward(0.0, -1, circle, None if headings is None else headings[0])
    best, last = math.inf, -1
    while queue and queue[0][0] < best:
        length, number, _ = heapq.heappop(queue)
        if number in done:
            continue
        done.add(number)
        line = lines[number]
        if line.end in (2, 3):
            turn = 0.0 if headings is None else _turn(circles[line.end], line.heading, headings[1])
            whole = length + circles[line.end].radius * turn
            if whole < best and _arc_free(circles[line.end], line.heading, turn, discs):
                best, last = whole, number
            continue
        onward(length, number, line.end, line.heading)
    if last < 0:
        return None
    chain = [last]
    while before[chain[-1]] >= 0:
        chain.append(before[chain[-1]])
    return _drawn([lines[number] for number in reversed(chain)], circles, headings, best)


def _turn(circle: _Circle, come: float | None, go: float) -> float:
    """Turn in [rad], 0 to 2 pi, from one heading to another on a circle."""
    if come is None:
        return 0.0
    turn = (circle.sense * (go - come)) % (2.0 * math.pi)
    return 0.0 if turn > 2.0 * math.pi - 1e-9 else turn


def _free_lines(circles: list[_Circle], discs: FloatArray) -> list[_Line]:
    """Return all tangents from one circle to another that meet no disc."""
    rows = np.array(circles)
    count = len(circles)
    first, second = (index.ravel() for index in np.meshgrid(range(count), range(count), indexing="ij"))
    keep = (first != second) & (second > 1) & ((first < 2) | (first > 3))
    first, second = first[keep], second[keep]
    signed = rows[:, 2] * rows[:, 3]
    away = rows[second, :2] - rows[first, :2]
    distance = np.hypot(*away.T)
    sine = (signed[second] - signed[first]) / np.maximum(distance, 1e-12)
    real = (np.abs(sine) <= 1.0) & (distance > 1e-9)
    first, second, away, distance, sine = (a[real] for a in (first, second, away, distance, sine))
    heading = np.arctan2(away[:, 1], away[:, 0]) - np.arcsin(sine)
    left = np.column_stack([-np.sin(heading), np.cos(heading)])
    start = rows[first, :2] - signed[first, None] * left
    end = rows[second, :2] - signed[second, None] * left
    free = _lines_free(start, end, discs)
    length = np.hypot(*(end - start).T)
    return [
        _Line(
            int(first[k]),
            int(second[k]),
            (float(start[k, 0]), float(start[k, 1])),
            float(heading[k]),
            float(length[k]),
        )
        for k in np.flatnonzero(free)
    ]


def _lines_free(start: FloatArray, end: FloatArray, discs: FloatArray) -> BoolArray:
    """Return (n,) which lines between points (n, 2) stay out of all discs."""
    ray = end - start
    square = np.maximum((ray**2).sum(axis=1), 1e-18)
    to_disc = discs[None, :, :2] - start[:, None]
    share = np.clip((to_disc * ray[:, None]).sum(axis=2) / square[:, None], 0.0, 1.0)
    gap = np.hypot(*np.moveaxis(to_disc - share[..., None] * ray[:, None], -1, 0))
    free: BoolArray = (gap > discs[:, 2] - TOUCH_TOLERANCE_M).all(axis=1)
    return free


def _arc_free(circle: _Circle, come: float, turn: float, discs: FloatArray) -> bool:
    """Return True if an arc over `turn` that begins with heading `come` stays out of all discs."""
    if turn == 0.0 or circle.radius == 0.0 or len(discs) == 0:
        return True
    begin = come - circle.sense * math.pi / 2.0  # direction from the middle to the car
    away = discs[:, :2] - (circle.x, circle.y)
    distance = np.hypot(*away.T)
    at = (circle.sense * (np.arctan2(away[:, 1], away[:, 0]) - begin)) % (2.0 * math.pi)
    ends = [
        np.hypot(*(away - circle.radius * np.array([math.cos(a), math.sin(a)])).T)
        for a in (begin, begin + circle.sense * turn)
    ]
    gap = np.where(at <= turn, np.abs(distance - circle.radius), np.minimum(*ends))
    return bool((gap > discs[:, 2] - TOUCH_TOLERANCE_M).all())


def _drawn(
    chain: list[_Line], circles: list[_Circle], headings: tuple[float, float] | None, length: float
) -> CarPath:
    """Points along the lines of a chain and the arcs before, between and after them."""
    pieces: list[FloatArray] = []
    come = chain[0].heading if headings is None else headings[0]
    for line in chain:
        pieces.append(_arc(circles[line.begin], come, line.heading))
        along = _steps(line.length)
        x = line.start[0] + along * math.cos(line.heading)
        y = line.start[1] + along * math.sin(line.heading)
        pieces.append(np.column_stack([x, y, np.full(len(x), line.heading), np.zeros(len(x))]))
        come = line.heading
    if headings is not None:
        pieces.append(_arc(circles[chain[-1].end], come, headings[1]))
    rows = np.vstack(pieces)
    rows[:, 2] = [wrap(angle) for angle in rows[:, 2].tolist()]
    return CarPath(rows[:, :3], rows[:, 3], length)


def _arc(circle: _Circle, come: float, go: float) -> FloatArray:
    """Return (n, 4) x, y, heading, curvature of an arc, without its first point."""
    turn = _turn(circle, come, go)
    heading = come + circle.sense * _steps(circle.radius * turn) / max(circle.radius, 1e-12)
    out = heading - circle.sense * math.pi / 2.0
    x, y = circle.x + circle.radius * np.cos(out), circle.y + circle.radius * np.sin(out)
    bend = circle.sense / circle.radius if circle.radius > 0.0 else 0.0
    return np.column_stack([x, y, heading, np.full(len(x), bend)])


def _steps(length: float) -> FloatArray:
    """Return even distances (n,) along a piece of a length, in [m], up to its end, without 0."""
    return np.linspace(0.0, length, math.ceil(length / PATH_SPACING_M - 1e-9) + 1)[1:]
