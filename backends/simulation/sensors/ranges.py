"""Ranges of a perfect lidar."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from handcart.backends.simulation.world.solids import FloorPlan
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

_CORNERS = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
_GRAZING = 1e-9  # [rad]


def cast_rays(plan: FloorPlan, sensor: Pose2, angles: FloatArray, time: float, reach: float) -> FloatArray:
    """Return the range (n,) in [m] of each beam to the first outline of the plan; infinity beyond `reach`.

    It uses the slab method of Kay and Kajiya, "Ray tracing complex scenes" (1986), for all outlines at once;
    each outline is tested only against beams in its direction. An outline that contains the sensor is not
    seen.

    Args:
        plan: outlines at the sensor's height.
        sensor: world_T_sensor.
        angles: (n,) of the beams in the sensor frame, in [rad], counter-clockwise from its x axis.
        time: simulated time in [s], which decides which surprises (unmapped obstacles) are present.
        reach: maximum range, in [m].
    """
    ranges = np.full(len(angles), np.inf)
    if not plan.names:
        return ranges
    here = plan.local(sensor.x, sensor.y)
    near = np.hypot(*np.maximum(np.abs(here) - plan.half, 0.0).T) < reach
    near &= plan.there(time)
    here, half = here[near], plan.half[near]
    heading = plan.headings[near] - sensor.theta
    outline, beam = _pairs(here, half, heading, angles)
    turned = angles[beam] - heading[outline]
    _shorten(ranges, outline, beam, np.cos(turned), np.sin(turned), here, half, reach)
    return ranges


def _pairs(
    here: FloatArray,
    half: FloatArray,
    heading: FloatArray,
    angles: FloatArray,
) -> tuple[IntArray, IntArray]:
    """Return the pairs of outlines and beams that may meet, as numbers of outlines (k,) and of beams (k,).

    They are found by the directions of the outlines' corners.

    Args:
        here: (m, 2) position of the sensor in the frames of m outlines, in [m].
        half: (m, 2) half lengths of the outlines along their x and y, in [m].
        heading: (m,) headings of the outlines in the sensor frame, in [rad].
        angles: (n,) of the beams in the sensor frame, in [rad].
    """
    order, around = _sorted_twice(angles.tobytes())
    corners = _CORNERS * half[:, None] - here[:, None]
    middle = np.arctan2(-here[:, 1], -here[:, 0])
    # Seen from outside no outline is as wide as half a turn.
    beside = _wrapped(np.arctan2(corners[..., 1], corners[..., 0]) - middle[:, None])
    low = beside.min(axis=1) - _GRAZING
    first = around[0] + np.mod(middle + heading + low - around[0], 2 * np.pi)
    begin = np.searchsorted(around, first)
    count = np.searchsorted(around, first + beside.max(axis=1) + _GRAZING - low) - begin
    outline = np.repeat(np.arange(len(here)), count)
    place = np.arange(len(outline)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(begin, count)
    return outline, order[place % len(angles)]


@lru_cache(maxsize=16)
def _sorted_twice(angles: bytes) -> tuple[IntArray, FloatArray]:
    """Return the order of beams by their angles (n,), and the sorted angles of two turns (2n,), in [rad]."""
    given = np.frombuffer(angles)
    order = np.argsort(given)
    return order, np.concatenate([given[order], given[order] + 2 * np.pi])


def _wrapped(angle: FloatArray) -> FloatArray:
    """Return angles wrapped to -pi to pi, in [rad], in the shape given."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


@compiled_for("(f8[::1], i8[::1], i8[::1], f8[::1], f8[::1], f8[:,::1], f8[:,::1], f8)")
def _shorten(
    ranges: FloatArray,
    outline: IntArray,
    beam: IntArray,
    cos: FloatArray,
    sin: FloatArray,
    here: FloatArray,
    half: FloatArray,
    reach: float,
) -> None:
    """Shorten the ranges (n,) of beams that meet an outline, in place, in [m].

    Args:
        ranges: (n,) ranges of the beams so far, in [m].
        outline: (k,) number of the outline of each pair that may meet.
        beam: (k,) number of the beam of each pair.
        cos: (k,) unit vectors of the beams along x of the outlines.
        sin: (k,) unit vectors of the beams along y of the outlines.
        here: (m, 2) position of the sensor in the frames of the outlines, in [m].
        half: (m, 2) half lengths of the outlines along their x and y, in [m].
        reach: maximum range, in [m].
    """
    for i in range(len(outline)):
        j = outline[i]
        enter, leave = _slab(here[j, 0], half[j, 0], cos[i])
        enter_y, leave_y = _slab(here[j, 1], half[j, 1], sin[i])
        enter, leave = max(enter, enter_y), min(leave, leave_y)
        if enter <= leave and 0.0 < enter <= reach and enter < ranges[beam[i]]:
            ranges[beam[i]] = enter


@compiled
def _slab(here: float, half: float, direction: float) -> tuple[float, float]:
    """Return the distances, in [m], along a beam at which it enters and leaves the strip between -half and
    half.

    Args:
        here: coordinate of the sensor across the strip, in [m].
        half: half width of the strip, in [m].
        direction: same coordinate of the beam's unit vector.
    """
    slope = 1.0 / (1e-12 if abs(direction) < 1e-12 else direction)
    middle, width = -here * slope, half * abs(slope)
    return middle - width, middle + width
