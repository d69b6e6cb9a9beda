"""Share of a scan's information along a direction that does not come from the raster of the map.

Gauss-Newton counts the slope of the likelihood field at every point as information. Along a straight wall
that is not parallel to the axes, the cells of the map form a staircase whose slopes say nothing: the scan
fits as well a hand's breadth farther on. So the scan is shifted along the direction that it determines
worst, and its cost has to rise as the slopes claim (the idea of Olson, 2009: sample the cost, not its
derivative).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray, Int32Array, Uint16Array
from handcart.robotics.numerics.compiled import compiled, compiled_fast

from .likelihood_field import STEPS_PER_CELL, FieldValues, LikelihoodField, beam_sectors

SHIFT_CELLS = np.array([2.6, 3.3, 4.3, 5.2])  # cells, each way: more than one, and no multiples of each other
MIN_SHARE = 0.12  # of the rise that the slopes claim; less is grain: up to 0.10 along a diagonal wall
PLAIN_SHARE = 0.8  # of it, above which a closer look is not needed
FAN_STEP = math.radians(2.0)
FAN_ANGLES = FAN_STEP * np.arange(-8, 9)  # [rad] from the direction that the slopes give: grain turns it
FAN_COS_SIN = np.column_stack([np.cos(FAN_ANGLES), np.sin(FAN_ANGLES)])
FAN_ACROSS = np.column_stack([-np.sin(FAN_ANGLES), np.cos(FAN_ANGLES)])
FIT_PARABOLA = np.linalg.pinv(np.vander(FAN_STEP * np.arange(-2, 3), 3))  # (3, 5): squares, slope, constant
FAN_POINTS = 120  # points by which those directions are compared
MIN_POINTS = 5.0  # points on a wall across the direction that the cost has to rise by
OFF_MAP_SCALES = 1e3  # scales: as far as a point beyond the map
NEAR_SCALES = 4.0  # scales from a surface, within which a point counts
NO_SLOPES = np.empty((0, 2))
MIN_SAME_DIRECTION_COSINE = 0.7  # cosine of two directions that are about the same


NearPoints = tuple[Int32Array, FloatArray, FloatArray, FloatArray]
"""Points of a scan near surfaces of a map, as `near_points` returns them."""


class ScanEvidence(NamedTuple):
    """Information of a scan about the position of the base in the scan's worst direction.

    The worst direction is the one in which the scan determines the position least, such as that along a
    corridor.
    """

    direction: FloatArray
    """(2,) unit vector on the map."""
    share: float
    """Share of the information along it that the cost confirms, 0 to 1; 0 where that is too little."""
    more: float = 0.0
    """Information in [1/m²] that the slopes miss: between the two sides of a thin wall the field is flat."""
    turn_share: float = 1.0
    """Share of the information about the heading that the cost confirms, 0 to 1 (`turn_evidence`)."""


def weakest_evidence(
    grid: GridMap,
    facing: Uint16Array,
    near: NearPoints,
    pose: Pose2,
    information: FloatArray,
    scale: float,
    noise: float,
) -> ScanEvidence:
    """Return the evidence of a scan about the direction in which it determines the position least.

    The scan is shifted along this direction; the evidence is the rise of the scan's cost.

    Args:
        grid: the map.
        facing: (k, h, w) distances of its cells to the nearest surface, as `LikelihoodField.facing`, in steps
            of 1 / `STEPS_PER_CELL` cells.
        near: points of the scan near surfaces of the map, at this pose.
        pose: map_T_base at which the scan fits best.
        information: (3, 3) information matrix of the scan alone: x, y on the map and heading, in [1/m²] and
            [1/rad²].
        scale: scale of the robust cost, in [m].
        noise: sigma of a point's distance, in [m].
    """
    lever = information[:2, 2] / max(float(information[2, 2]), 1e-9)
    inner = information[:2, :2] - lever[:, None] * information[2, :2]
    direction = _weakest_axis(inner)
    if not len(near[1]):
        return ScanEvidence(direction, 0.0)
    shifted = _Shifted(grid, facing, *near, np.array(pose[:2]), lever, scale)
    across, claimed = shifted.rise(direction)
    if across < PLAIN_SHARE * claimed:
        direction = shifted.flattest(direction)
        across, claimed = shifted.rise(direction)
    if across < max(MIN_POINTS, MIN_SHARE * claimed):
        return ScanEvidence(direction, 0.0)
    by_slopes = float(direction @ inner @ direction) * noise**2
    share = min(1.0, across / max(by_slopes, 1e-9))
    return ScanEvidence(direction, share, max(0.0, across - by_slopes) / noise**2)


def _weakest_axis(information: FloatArray) -> FloatArray:
    """Return the unit vector (2,) along which an information (2, 2) is least: its eigenvector."""
    (xx, _), (xy, yy) = information.tolist()
    strongest = 0.5 * math.atan2(2.0 * xy, xx - yy)
    return np.array([-math.sin(strongest), math.cos(strongest)])


class _Shifted(NamedTuple):
    """A scan that is shifted about on a map, its heading following."""

    grid: GridMap
    facing: Uint16Array
    """Distances (k, h, w) of the map's cells to the nearest surface that faces the sensor, in steps."""
    sectors: Int32Array
    """(m,) which of the k distances each point reads."""
    points: FloatArray
    """(m, 2) on the map, in [m]."""
    distances: FloatArray
    """(m,) of the points as they are, in [m]."""
    slopes: FloatArray
    """(m, 2) of the distances, along x and y."""
    middle: FloatArray
    """(2,) position of the base on the map, in [m]."""
    lever: FloatArray
    """(2,) by which the heading turns back with a shift along x and y of the map, in [rad/m]."""
    scale: float

    def rise(self, direction: FloatArray) -> tuple[float, float]:
        """Rise of the cost along a direction (2,), as it is seen and as the slopes claim it.

        Both in units of one point on a wall straight across: the number of such points that would make the
        cost rise as much. The least of several shifts counts, because a raster that fits as before after one
        of them does not after another.
        """
        rises = self._rises(direction[None], 1, self.slopes)[0].tolist()
        return min(seen / one for seen, _, one in rises), min(claimed / one for _, claimed, one in rises)

    def flattest(self, direction: FloatArray) -> FloatArray:
        """Direction (2,) near this one along which the cost rises least: that of the walls."""
        x, y = direction.tolist()
        rays = FAN_COS_SIN * x + FAN_ACROSS * y
        rises = self._rises(rays, max(1, len(self.points) // FAN_POINTS), NO_SLOPES)[:, :, 0].sum(axis=1)
        least = min(max(int(rises.argmin()), 2), len(FAN_ANGLES) - 3)
        bend, slope, _ = (FIT_PARABOLA @ rises[least - 2 : least + 3]).tolist()
        off = min(FAN_STEP, max(-FAN_STEP, -0.5 * slope / bend)) if bend > 0.0 else 0.0
        turned = FAN_ANGLES[least] + off
        return np.array(
            [math.cos(turned) * x - math.sin(turned) * y, math.sin(turned) * x + math.cos(turned) * y]
        )

    def _rises(self, rays: FloatArray, every: int, slopes: FloatArray) -> FloatArray:
        """Return `rises` along directions (k, 2), by each point whose number is a multiple of `every`."""
        grid = self.grid
        steps, corner = SHIFT_CELLS * grid.resolution, (grid.origin_x, grid.origin_y)
        motions = np.column_stack([rays, self.lever[0] * rays[:, 0] + self.lever[1] * rays[:, 1]])
        where = motions, steps, every, corner, grid.resolution, self.facing, self.sectors, self.points
        return rises(*where, self.distances, slopes, self.middle, self.scale)


def near_surfaces(
    field: LikelihoodField, points: FloatArray, reading: FieldValues, pose: Pose2, scale: float
) -> NearPoints:
    """Return the points of a scan whose costs are compared: those up to four scales from a surface.

    Args:
        field: likelihood field of the map.
        points: (n, 2) end points of the beams, on the map, in [m].
        reading: values of the field at the points.
        pose: map_T_base at which the scan was taken.
        scale: scale of the robust cost, in [m].
    """
    return near_points(
        points, reading.distances, reading.slopes, NEAR_SCALES * scale, pose[:2], len(field.facing)
    )


@compiled
def near_points(
    points: FloatArray,
    distances: FloatArray,
    slopes: FloatArray,
    limit: float,
    sensor: tuple[float, float],
    sector_count: int,
) -> NearPoints:
    """Return the points of a scan that are near surfaces of a map, with their values.

    Args:
        points: (n, 2) end points of beams on the map, in [m].
        distances: (n,) of the points to the nearest surface, in [m].
        slopes: (n, 2) of the distances along x and y of the map.
        limit: distance below which a point is near, in [m].
        sensor: x and y of the sensor on the map, in [m].
        sector_count: length of `LikelihoodField.facing`.

    Returns:
        Of the m near points: sectors (m,) as `beam_sectors` returns them, points (m, 2), distances (m,) and
            slopes (m, 2).
    """
    seen, near, sloped = np.empty((len(points), 2)), np.empty(len(points)), np.empty((len(points), 2))
    count = 0
    for i in range(len(points)):
        if distances[i] < limit:
            seen[count, 0], seen[count, 1] = points[i, 0], points[i, 1]
            sloped[count, 0], sloped[count, 1] = slopes[i, 0], slopes[i, 1]
            near[count] = distances[i]
            count += 1
    seen = seen[:count]
    return beam_sectors(seen, sensor, sector_count), seen, near[:count], sloped[:count]


@compiled_fast
def rises(
    motions: FloatArray,
    steps: FloatArray,
    every: int,
    origin: tuple[float, float],
    resolution: float,
    facing: Uint16Array,
    sectors: Int32Array,
    points: FloatArray,
    distances: FloatArray,
    slopes: FloatArray,
    middle: FloatArray,
    scale: float,
) -> FloatArray:
    """Return how much the matching cost of a scan rises for a motion of the scan, plus its rise for the
    opposite motion.

    Args:
        motions: (k, 3) shifts along x and y of the map, and clockwise turns about `middle`, in [rad], for
            each metre of a step.
        steps: (n,) lengths of the steps along each motion, in [m].
        every: only points whose number is a multiple of this are used.
        origin: lower-left corner of the map in its frame, in [m].
        resolution: side of a cell, in [m].
        facing: (s, h, w) distances of the cells to the nearest surface that faces a direction, for each of s
            directions, as `LikelihoodField.facing`, in steps of 1 / `STEPS_PER_CELL` cells.
        sectors: (m,) index along the first axis of `facing` of the direction from each point to the lidar.
        points: (m, 2) of the scan on the map, in [m].
        distances: (m,) of the points to the nearest surface, in [m].
        slopes: (m, 2) slopes of the distances, without unit; empty if the rise expected from the slopes is
            not needed.
        middle: (2,) centre of the turns on the map, in [m].
        scale: scale of the robust cost, in [m].

    Returns:
        (k, n, 3) in [m²], for each motion and step: the actual rise, the rise expected from the slopes, and
            the rise of a single point that moves by the step at right angles to a wall.
    """
    count, per = (len(points) + every - 1) // every, 1.0 / resolution
    out, before = np.zeros((len(motions), len(steps), 3)), 0.0
    at, moved, plane = np.empty((2, count)), np.empty((2, count)), np.empty(count, dtype=np.int32)
    area = facing.shape[1] * facing.shape[2]
    for i in range(count):
        at[0, i] = (points[i * every, 0] - origin[0]) * per - 0.5
        at[1, i] = (points[i * every, 1] - origin[1]) * per - 0.5
        plane[i] = sectors[i * every] * area
        before += _cost(min(distances[i * every], OFF_MAP_SCALES * scale) ** 2, scale)
    for k in range(len(motions)):
        x, y, turn = motions[k, 0], motions[k, 1], motions[k, 2]
        for i in range(count):  # cells moved by, for each metre of a step
            moved[0, i] = (x + turn * (points[i * every, 1] - middle[1])) * per
            moved[1, i] = (y - turn * (points[i * every, 0] - middle[0])) * per
        for j in range(len(steps)):
            forth = _shifted_cost(facing, plane, at, moved, steps[j], resolution, scale)
            back = _shifted_cost(facing, plane, at, moved, -steps[j], resolution, scale)
            out[k, j, 0] = forth + back - 2.0 * before
            out[k, j, 2] = 2.0 * _cost(steps[j] ** 2, scale)
            if len(slopes):
                length = steps[j] * resolution
                for i in range(count):
                    slope = slopes[i * every, 0] * moved[0, i] + slopes[i * every, 1] * moved[1, i]
                    out[k, j, 1] += 2.0 * _cost((length * slope) ** 2, scale)
    return out


@compiled_fast
def _shifted_cost(
    facing: Uint16Array,
    plane: Int32Array,
    at: FloatArray,
    moved: FloatArray,
    step: float,
    resolution: float,
    scale: float,
) -> float:
    """Cost in [m²] of points at columns and rows (2, n) that are moved, (2, n) a metre, by a step.

    `plane` (n,) is where the distances that each point reads begin in the flat array.

    Without a branch, so that several points are read at once; see `likelihood_field.read_field`. A point
    beyond the map costs as much as one far off.
    """
    _, height, width = facing.shape
    cells, total, unit = facing.reshape(-1), 0.0, resolution / STEPS_PER_CELL
    if height < 2 or width < 2:
        return float(at.shape[1] * _cost((OFF_MAP_SCALES * scale) ** 2, scale))
    for i in range(at.shape[1]):
        u, v = at[0, i] + step * moved[0, i], at[1, i] + step * moved[1, i]
        inside = (u >= 0.0) & (u < width - 1.0) & (v >= 0.0) & (v < height - 1.0)
        u, v = u if inside else 0.0, v if inside else 0.0
        column, row = np.int32(u), np.int32(v)
        u, v = u - column, v - row
        cell = plane[i] + row * np.int32(width) + column
        # Numba asks of each index that may be negative whether it is.
        a, b = np.float64(cells[np.uint32(cell)]), np.float64(cells[np.uint32(cell + 1)])
        c, d = np.float64(cells[np.uint32(cell + width)]), np.float64(cells[np.uint32(cell + width + 1)])
        low, high = a + (b - a) * u, c + (d - c) * u
        off = (low + (high - low) * v) * unit if inside else OFF_MAP_SCALES * scale
        total += _cost(off**2, scale)
    return total


@compiled_fast
def _cost(square: float, scale: float) -> float:
    """Cost of Geman and McClure, in [m²], of a point at a distance whose square is given in [m²]."""
    return square * scale**2 / (scale**2 + square)


def confirmed(seen: ScanEvidence, before: ScanEvidence | None) -> ScanEvidence:
    """Return a scan's evidence, with `share` (the usable part of the information) 0 if the previous scan
    contradicts it.

    That is so if the previous scan determined the position worst in about the same direction, and gave no
    usable evidence there; and for `turn_share` if the previous scan gave none about the heading.

    The steps between the cells of a diagonal wall may give false evidence in a single scan, but rarely in two
    successive ones.

    Args:
        seen: evidence of the current scan.
        before: evidence of the previous scan; None if there is none, and `seen` is returned unchanged.
    """
    if before is None:
        return seen
    if before.turn_share == 0.0:
        seen = seen._replace(turn_share=0.0)
    if before.share > 0.0:
        return seen
    return (
        seen._replace(share=0.0, more=0.0)
        if abs(float(seen.direction @ before.direction)) > MIN_SAME_DIRECTION_COSINE
        else seen
    )


def unrelated(covariance: FloatArray, seen: ScanEvidence) -> FloatArray:
    """Return a prior's covariance (3, 3) without correlation between a scan's worst direction and the rest.

    The worst direction is the one in which a scan does not determine the position. It is known only
    approximately, so that with such a correlation the scan would wrongly correct the position in this
    direction too.

    Args:
        covariance: (3, 3) of x, y on the map in [m] and heading in [rad].
        seen: the scan's evidence; if its share is above 0, the scan determines all directions, and the
            covariance is returned unchanged.
    """
    if seen.share > 0.0:
        return covariance
    ray = np.array([*seen.direction, 0.0])
    rest = np.eye(3) - np.outer(ray, ray)
    return np.asarray(rest @ covariance @ rest + float(ray @ covariance @ ray) * np.outer(ray, ray))
