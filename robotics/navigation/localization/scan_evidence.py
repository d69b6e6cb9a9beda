"""How much of a scan's information about a direction is more than the grain of the map.

Gauss-Newton counts the slope of the likelihood field at every point as information. Along a straight wall
that is not parallel to the axes, the cells of the map form a staircase whose slopes say nothing: the scan
fits as well a hand's breadth farther on. So the scan is shifted along the direction that it determines worst,
and its cost has to rise as the slopes claim (the idea of Olson, 2009: sample the cost, not its derivative).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2

from .likelihood_field import LikelihoodField

SHIFTS = np.array([2.6, 3.3, 4.3, 5.2])  # cells, each way: more than one, and no multiples of each other
MIN_SHARE = 0.12  # of the rise that the slopes claim; less is grain: up to 0.10 along a diagonal wall
PLAIN_SHARE = 0.8  # of it; no less, and there is no need to look closer
FAN_STEP = math.radians(2.0)
FAN = FAN_STEP * np.arange(-8, 9)  # [rad] from the direction that the slopes give: grain turns it
FAN_POINTS = 120  # points by which those directions are compared
MIN_POINTS = 5.0  # points on a wall across the direction that the cost has to rise by

SAME = 0.7  # cosine of two directions that are about the same

Array = NDArray[np.float64]


class Evidence(NamedTuple):
    """What a scan says about the direction that it determines worst."""

    direction: Array
    """(2,) unit vector on the map."""
    share: float
    """Share of the information about it that the cost confirms, 0 to 1; 0 where that is too little."""
    more: float = 0.0
    """Information in [1/m²] that the slopes miss: between the two sides of a thin wall the field is flat."""


def weakest_evidence(
    field: LikelihoodField, points: Array, pose: Pose2, information: Array, scale: float, noise: float
) -> Evidence:
    """Shift a scan along the direction that it determines worst, and see whether its cost rises.

    Args:
        field: of the map.
        points: (n, 2) where beams ended, in the base frame, in [m].
        pose: map_T_base that fits best.
        information: (3, 3) of the scan alone, of x, y in [m] and heading in [rad].
        scale: of the robust cost, in [m].
        noise: sigma of a point's distance, in [m].
    """
    lever = information[:2, 2] / max(float(information[2, 2]), 1e-9)
    inner = information[:2, :2] - np.outer(lever, information[2, :2])
    _, axes = np.linalg.eigh(inner)
    direction = axes[:, 0]
    seen = pose.apply(points)
    distances, slopes = field.slopes(seen)
    used = distances < 4.0 * scale
    if not used.any():
        return Evidence(direction, 0.0)
    shifted = _Shifted(field, seen[used], np.array(pose[:2]), distances[used], lever, scale)
    across, claimed = shifted.rise(direction, slopes[used])
    if across < PLAIN_SHARE * claimed:
        direction = shifted.flattest(direction)
        across, claimed = shifted.rise(direction, slopes[used])
    if across < max(MIN_POINTS, MIN_SHARE * claimed):
        return Evidence(direction, 0.0)
    by_slopes = float(direction @ inner @ direction) * noise**2
    share = min(1.0, across / max(by_slopes, 1e-9))
    return Evidence(direction, share, max(0.0, across - by_slopes) / noise**2)


class _Shifted(NamedTuple):
    """A scan that is shifted about on a map, its heading following."""

    field: LikelihoodField
    points: Array
    """(m, 2) on the map, in [m]."""
    middle: Array
    """(2,) the base, in [m]."""
    distances: Array
    """(m,) of the points as they are, in [m]."""
    lever: Array
    """(2,) by which the heading turns back with a shift, in [rad/m]."""
    scale: float

    def rise(self, direction: Array, slopes: Array) -> tuple[float, float]:
        """Rise of the cost along a direction (2,), as it is seen and as the slopes (m, 2) claim it.

        Both as a number of points: those on a wall straight across that would make it rise as much. The least
        of several shifts counts: grain that lies as before after one of them doesn't after another.
        """
        steps = SHIFTS * self.field.map.resolution
        one = 2.0 * _cost(steps, self.scale)
        along = (slopes * self._ways(direction, self.points)).sum(axis=1)
        claimed = 2.0 * _cost(steps[:, None] * np.abs(along), self.scale).sum(axis=1)
        return float((self._rises(direction[None], 1)[0] / one).min()), float((claimed / one).min())

    def flattest(self, direction: Array) -> Array:
        """Direction (2,) near this one along which the cost rises least: that of the walls."""
        cos, sin = np.cos(FAN), np.sin(FAN)
        x, y = direction
        rays = np.column_stack([cos * x - sin * y, sin * x + cos * y])
        rises = self._rises(rays, max(1, len(self.points) // FAN_POINTS)).sum(axis=1)
        least = int(np.clip(np.argmin(rises), 2, len(FAN) - 3))
        near = slice(least - 2, least + 3)
        bend, slope, _ = np.polyfit(FAN[near] - FAN[least], rises[near], 2)
        off = np.clip(-0.5 * slope / bend, -FAN_STEP, FAN_STEP) if bend > 0.0 else 0.0
        turned = float(FAN[least] + off)
        return np.array(
            [math.cos(turned) * x - math.sin(turned) * y, math.sin(turned) * x + math.cos(turned) * y]
        )

    def _ways(self, direction: Array, points: Array) -> Array:
        """(m, 2) by which each point moves, for each metre that the base does."""
        arm = points - self.middle
        return np.asarray(
            direction - float(self.lever @ direction) * np.column_stack([-arm[:, 1], arm[:, 0]])
        )

    def _rises(self, rays: Array, every: int) -> Array:
        """Rise of the cost (k, n) along directions (k, 2), forth and back, by every so manieth point."""
        steps, points = SHIFTS * self.field.map.resolution, self.points[::every]
        ways = np.array([self._ways(ray, points) for ray in rays])
        moved = points + np.array([-steps, steps])[:, None, :, None, None] * ways[:, None]
        after = _cost(self.field.read(moved.reshape(-1, 2)), self.scale)
        before = 2.0 * _cost(self.distances[::every], self.scale).sum()
        return np.asarray(after.reshape(2, len(rays), len(steps), -1).sum(axis=(0, 3)) - before)


def confirmed(seen: Evidence, before: Evidence | None) -> Evidence:
    """The evidence if the scan before said so too: grain is taken for more than that only now and then."""
    if before is None or before.share > 0.0:
        return seen
    return (
        seen._replace(share=0.0, more=0.0) if abs(float(seen.direction @ before.direction)) > SAME else seen
    )


def unrelated(covariance: Array, seen: Evidence) -> Array:
    """(3, 3) of a prior whose error along the direction says nothing about the rest, if the scan doesn't.

    The direction is only about right: through such a relation, the scan would seem to determine it.
    """
    if seen.share > 0.0:
        return covariance
    ray = np.array([*seen.direction, 0.0])
    rest = np.eye(3) - np.outer(ray, ray)
    return np.asarray(rest @ covariance @ rest + float(ray @ covariance @ ray) * np.outer(ray, ray))


def _cost(distances: Array, scale: float) -> Array:
    """Cost of Geman and McClure, in [m²]: of points beyond the map that of points far off."""
    squares = np.minimum(distances, 1e3 * scale) ** 2
    return np.asarray(squares / (1.0 + squares / scale**2))
