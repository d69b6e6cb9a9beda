"""Scan of the surface that the base is at: a table may not be where its file says."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.robot.localization.lidar import beams_of
from handcart.backends.robot.robot import Robot
from handcart.primitives.objects.files.surface import PLACED_SIGMA_M, PLACED_SIGMA_RAD, ObjectSurface
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.rectangle_scan import fit_rectangle
from handcart.robotics.numerics.arrays import FloatArray

SURFACE_SCANS = 10  # of one measurement
MIN_BELOW_TOP_M = 0.02  # that the lidar is lower than a surface's top


def scan_surface(
    robot: Robot, surface: ObjectSurface
) -> Generator[None, None, tuple[Pose2, FloatArray] | None]:
    """Return a surface's pose on the map, and its covariance (3, 3) of x, y in [m] and heading in [rad].

    The covariance is along the map's axes, without the uncertainty of the base's pose. None if the surface
    isn't seen.

    Args:
        robot: robot before the surface.
        surface: the surface, at the pose of its file.
    """
    assert robot.lidar is not None
    yield from settle(robot)
    scans = []
    for _ in range(SURFACE_SCANS):
        yield
        scans.append(beams_of(robot.lidar))
    expected = robot.pose.inverse().compose(surface.floor)
    sigma = robot.lidar.spec.sigma_mm / 1e3
    found = yield from robot.compute(
        fit_rectangle, scans, surface.size_m, expected, _prior(robot, expected), sigma
    )
    if found is None:
        return None
    turn = Pose2(0.0, 0.0, robot.pose.theta).lift()[:3, :3]
    return robot.pose.compose(found.pose), np.asarray(turn @ found.covariance @ turn.T)


def is_in_scan(robot: Robot, surface: ObjectSurface) -> bool:
    """Return whether the lidar can measure the sides of a surface: the surface is solid down to the floor,
    has no walls, and is higher than the lidar. False without a lidar.
    """
    is_solid = surface.thickness_m is None and not surface.walls
    is_high = robot.lidar is not None and robot.range_sensor_height < surface.height_m - MIN_BELOW_TOP_M
    return is_solid and is_high


def _prior(robot: Robot, expected: Pose2) -> FloatArray:
    """Return the covariance (3, 3) of a surface's expected pose in the base frame, of x, y in [m] and heading
    in [rad].
    """
    turn = Pose2(0.0, 0.0, -robot.pose.theta).lift()[:3, :3]
    base = turn @ robot.localization.covariance @ turn.T
    by_base = np.array([[1.0, 0.0, -expected.y], [0.0, 1.0, expected.x], [0.0, 0.0, 1.0]])
    placed = np.diag([PLACED_SIGMA_M, PLACED_SIGMA_M, PLACED_SIGMA_RAD]) ** 2
    return np.asarray(by_base @ base @ by_base.T + placed)
