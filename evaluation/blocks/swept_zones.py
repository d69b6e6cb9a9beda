"""Zones that the base must avoid, so that the turning robot touches nothing on tables."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.transform import apply
from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere
from handcart.robotics.numerics.arrays import FloatArray

CYLINDER_POINTS = 24  # points around a cylinder
MIN_ZONE_SIDE_M = 0.01  # [m] of a zone's side
ZONE_MARGIN_M = 0.01  # [m] above and below

Zone = tuple[float, float, float, float, float]
"""Rectangle on the map as x, y of its middle in [m], yaw in [rad], length and width in [m]."""


def swept_zones(spec: RobotFile, things: Sequence[Box]) -> list[Zone]:
    """Return a keepout zone around each thing, so that the robot in its posture `home` cannot touch the
    thing.

    The zones are for planning with the base's footprint. Where the robot's bodies at a thing's height reach
    less far than the footprint, the thing's zone is smaller by the difference. A thing at whose height the
    robot has no body gets no zone.

    Args:
        spec: robot file.
        things: upright boxes, posed on the map.
    """
    bodies = [_points(shape) for shape in spec.arm_model().link_shapes(np.array(spec.posture("home")))]
    zones = []
    for thing in things:
        low, high = (
            thing.pose[2, 3] - thing.size[2] / 2 - ZONE_MARGIN_M,
            thing.pose[2, 3] + thing.size[2] / 2 + ZONE_MARGIN_M,
        )
        beside = [body for body in bodies if body[:, 2].min() < high and body[:, 2].max() > low]
        if not beside:
            continue
        reach = max(float(np.hypot(item[:, 0], item[:, 1]).max()) for item in beside)
        spare = max(0.0, spec.footprint_radius_m - reach)
        less = 2.0 * spare / math.sqrt(2.0)  # at a corner both sides count
        yaw = math.atan2(thing.pose[1, 0], thing.pose[0, 0])
        length, width = (max(MIN_ZONE_SIDE_M, side - less) for side in thing.size[:2])
        zones.append((float(thing.pose[0, 3]), float(thing.pose[1, 3]), yaw, length, width))
    return zones


def _points(shape: Shape) -> FloatArray:
    """Return points (n, 3) whose convex hull nearly is the shape, in the frame in which the shape is posed,
    in [m].
    """
    if isinstance(shape, Box):
        corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        return apply(shape.pose, corners * shape.size)
    if isinstance(shape, Sphere):
        return shape.pose[:3, 3] + shape.radius * np.vstack((np.eye(3), -np.eye(3)))
    if isinstance(shape, Cylinder):
        turns = np.linspace(0.0, 2.0 * math.pi, CYLINDER_POINTS, endpoint=False)
        ring = shape.radius * np.column_stack((np.cos(turns), np.sin(turns), np.zeros(CYLINDER_POINTS)))
        up = np.array((0.0, 0.0, shape.length / 2))
        ends = np.vstack((ring - up, ring + up))
        return apply(shape.pose, ends)
    assert isinstance(shape, Hull)
    return apply(shape.pose, shape.points)
