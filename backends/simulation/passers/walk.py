"""Walks along waypoints: position, direction and distance walked at any time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

from .passer_spec import PasserSpec

MAX_MITRE = 3.0  # by which a companion's path goes farther out at a corner, at most


class WalkStep(NamedTuple):
    """Position, direction and speed of a walking person at one instant."""

    position: FloatArray
    """Position (2,) in the world, in [m]."""
    direction: FloatArray
    """Unit vector (2,) in the world in which the walker walks, or walked last."""
    walked: float
    """Distance walked since the start, in [m]."""
    speed: float
    """Present speed in [m/s]."""


class Walk:
    """Walk of one person along waypoints, by a clock that stops while the person yields to the robot."""

    def __init__(self, spec: PasserSpec, offset: float = 0.0, speed: float | None = None) -> None:
        """Plan a walk.

        Args:
            spec: section of the world's file.
            offset: distance to the left of the waypoints' path, in [m].
            speed: speed in [m/s] (default: that of the section).
        """
        path = np.array(spec.waypoints_m, dtype=np.float64)
        points = _beside(path, offset, spec.at_end == "loop")
        pauses = list(spec.pauses_s) or [0.0] * len(points)
        order = [*range(len(points))]
        self._around = len(points) > 1 and spec.at_end != "stay"
        if self._around:
            order += [0] if spec.at_end == "loop" else [*range(len(points) - 2, -1, -1)]
        seconds = np.hypot(*np.diff(path[order], axis=0).T) / (spec.speed_m_s if speed is None else speed)
        self._knots(points[order], [pauses[i] for i in order], seconds)

    def _knots(self, points: FloatArray, pauses: list[float], seconds: FloatArray) -> None:
        """Plan the times of arrival at and departure from each point of one cycle; its last point is the
        first of the next cycle.

        Args:
            points: (n, 2) points of the path in the world, in [m].
            pauses: n pauses at the points, in [s].
            seconds: (n - 1,) times from point to point, in [s]; a companion takes as long as the passer whose
                path it follows.
        """
        lengths = np.hypot(*np.diff(points, axis=0).T)
        times, places, walked = [0.0], [points[0]], [0.0]
        for number, point in enumerate(points):
            if number:
                times.append(times[-1] + float(seconds[number - 1]))
                places.append(point)
                walked.append(walked[-1] + lengths[number - 1])
            is_last = number == len(points) - 1
            if pauses[number] > 0.0 and not (is_last and self._around):
                times.append(times[-1] + pauses[number])
                places.append(point)
                walked.append(walked[-1])
        self._times, self._places, self._walked = np.array(times), np.array(places), np.array(walked)
        self._directions = [self._direction(index) for index in range(len(times) - 1)]

    def at(self, clock: float) -> WalkStep:
        """Return position and motion of the walker.

        Args:
            clock: time since the start, in [s], with pauses at waypoints but without time spent yielding.
        """
        last = float(self._times[-1])
        laps, clock = divmod(clock, last) if self._around else (0.0, min(max(clock, 0.0), last))
        index = int(np.searchsorted(self._times, clock, side="right")) - 1
        index = max(0, min(index, len(self._times) - 2))
        if len(self._times) < 2:
            return WalkStep(self._places[0].copy(), np.array([1.0, 0.0]), 0.0, 0.0)
        seconds = float(self._times[index + 1] - self._times[index])
        share = 0.0 if seconds <= 0.0 else min(1.0, (clock - float(self._times[index])) / seconds)
        position = self._places[index] + share * (self._places[index + 1] - self._places[index])
        walked = float(self._walked[index] + share * (self._walked[index + 1] - self._walked[index]))
        pace = float(self._walked[index + 1] - self._walked[index]) / seconds if seconds > 0.0 else 0.0
        stands = not self._around and clock >= last
        total = laps * float(self._walked[-1]) + walked
        return WalkStep(position, self._directions[index], total, 0.0 if stands else pace)

    def _direction(self, index: int) -> FloatArray:
        """Return the unit vector (2,) of the segment after a planned time; during a pause, that of the last
        segment before it.
        """
        steps = np.diff(self._places, axis=0)
        order = [*range(index, -1, -1), *range(index + 1, len(steps))]
        for number in order:
            length = float(np.hypot(*steps[number]))
            if length > 0.0:
                return np.asarray(steps[number] / length)
        return np.array([1.0, 0.0])


def _beside(points: FloatArray, offset: float, loops: bool) -> FloatArray:
    """Return a path (n, 2) next to another one, in the world, in [m].

    Args:
        points: (n, 2) path in the world, in [m].
        offset: distance to the left of the path, in [m].
        loops: True if the path is closed.
    """
    if offset == 0.0:
        return points
    if len(points) < 2:
        return np.asarray(points + np.array([0.0, offset]))
    rays = np.diff(np.vstack([points, points[:1]]) if loops else points, axis=0)
    lefts = np.column_stack([-rays[:, 1], rays[:, 0]]) / np.hypot(*rays.T)[:, None]
    before = np.roll(lefts, 1, axis=0) if loops else np.vstack([lefts[:1], lefts])
    after = lefts if loops else np.vstack([lefts, lefts[-1:]])
    middle = before + after
    squared = (middle**2).sum(axis=1)
    mitre = 2.0 / np.maximum(squared, 2.0 / MAX_MITRE)
    middle = np.where(squared[:, None] > 1e-9, middle * mitre[:, None], after)
    return np.asarray(points + offset * middle)
