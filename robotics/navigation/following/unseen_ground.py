"""Positions where a round robot would drive over ground that its lidar can't see."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

LOOK_AHEAD_M = 0.3
"""Minimum length of the route that is checked, however slow the robot is."""
HIDDEN_M = 0.15
"""Width of unseen ground on the leading edge that may hide something; narrower gaps are driven into."""
LEADING_RAD = math.radians(60.0)
"""Half angle of the footprint's leading edge about the direction of motion."""
EDGE_STEP_M = 0.015
DRIVEN_NEAR_M = 0.10
"""Largest distance from the robot's track at which its centre is on ground that it drove over."""


def unseen_edge(
    angles: FloatArray,
    blind: BoolArray,
    base_T_sensor: Pose2,
    radius: float,
    curvature: float,
    length: float,
) -> FloatArray | None:
    """Return the middle of unseen ground that a disc-shaped robot would reach on an arc; None if the lidar
    sees enough.

    The front edge of the disc at the arc's end is checked. Ground is unseen where no beam with a reading
    points.

    Args:
        angles: (n,) angles of the beams in the sensor frame, ascending, in [rad].
        blind: (n,) True for beams without a reading, which show neither an obstacle nor free ground.
        base_T_sensor: pose of the lidar.
        radius: radius of the disc, in [m].
        curvature: curvature of the arc, in [1/m], positive to the left.
        length: length of the arc, in [m]; below zero backwards.

    Returns:
        (2,) in the base frame, in [m].
    """
    if len(angles) < 2:
        return None
    spacing = float(angles[-1] - angles[0]) / (len(angles) - 1)
    far = max(abs(length), LOOK_AHEAD_M)
    whole = angles[-1] - angles[0] + 1.5 * spacing > 2.0 * math.pi
    if (
        whole
        and np.count_nonzero(blind) * spacing * (far + radius + math.hypot(*base_T_sensor[:2])) < HIDDEN_M
    ):
        return None
    edge = _leading_edge(radius, curvature, math.copysign(far, length))
    local = base_T_sensor.inverse().apply(edge)
    bearing = np.arctan2(local[:, 1], local[:, 0])
    unseen = ~_is_seen(bearing, angles, blind, spacing)
    start, end = _longest_run(unseen)
    if (end - start) * EDGE_STEP_M < HIDDEN_M:
        return None
    return np.asarray(edge[(start + end) // 2])


def is_driven(
    driven: FloatArray, pose: Pose2, curvature: float, length: float, near: float = DRIVEN_NEAR_M
) -> bool:
    """Return whether the robot's centre, on an arc, stays near positions where it has been before.

    Args:
        driven: (n, 2) earlier positions of the robot's centre, on the map, in [m].
        pose: map_T_base.
        curvature: curvature of the arc, in [1/m], positive to the left.
        length: length of the arc, in [m]; below zero backwards.
        near: allowed distance from `driven`, in [m].
    """
    if len(driven) == 0:
        return False
    steps = np.linspace(0.0, length, max(2, math.ceil(abs(length) / (0.5 * near)) + 1))
    arc = pose.apply(np.array([_on_arc(curvature, along) for along in steps.tolist()]))
    apart = np.hypot(*(arc[:, None] - driven[None]).transpose(2, 0, 1)).min(axis=1)
    return bool(apart.max() <= near)


def _leading_edge(radius: float, curvature: float, length: float) -> FloatArray:
    """Return points (k, 2) on the leading edge of a disc at the end of an arc.

    They are in the base frame, counter-clockwise, in [m].
    """
    heading = curvature * length + (math.pi if length < 0.0 else 0.0)
    count = max(3, math.ceil(2.0 * LEADING_RAD * radius / EDGE_STEP_M) + 1)
    around = heading + np.linspace(-LEADING_RAD, LEADING_RAD, count)
    return np.array(_on_arc(curvature, length)) + radius * np.column_stack([np.cos(around), np.sin(around)])


def _is_seen(bearing: FloatArray, angles: FloatArray, blind: BoolArray, spacing: float) -> BoolArray:
    """Return (k,) whether the beam nearest to each bearing has a reading, and is near enough."""
    around = angles[0] - 0.75 * spacing + np.mod(bearing - angles[0] + 0.75 * spacing, 2.0 * math.pi)
    nearest = np.clip(np.rint((around - angles[0]) / spacing).astype(int), 0, len(angles) - 1)
    off = np.abs((around - angles[nearest] + math.pi) % (2.0 * math.pi) - math.pi)
    return np.asarray((off <= 0.75 * spacing) & ~blind[nearest])


def _longest_run(flags: BoolArray) -> tuple[int, int]:
    """Start and end of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    if len(edges) == 0:
        return 0, 0
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest])


def _on_arc(curvature: float, along: float) -> tuple[float, float]:
    turn = curvature * along
    if abs(turn) < 1e-6:
        return along, 0.5 * turn * along
    return math.sin(turn) / curvature, (1.0 - math.cos(turn)) / curvature
