"""Measured pose of the surface that the base is at: a table may have been moved against its file."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator

import numpy as np

from handcart.backends.robot.localization.lidar import beams_of
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.files.surface import PLACED_SIGMA_M, PLACED_SIGMA_RAD, ObjectSurface
from handcart.primitives.objects.knowledge.objects import Objects, SurfacePose
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.rectangle_scan import fit_rectangle
from handcart.robotics.numerics.arrays import FloatArray

SURFACE_SCANS = 10  # of one measurement
MIN_BELOW_TOP_M = 0.02  # that the lidar is lower than a surface's top


def measure_surface(
    robot: Robot, model: ModelView, name: str, report: Callable[..., None]
) -> Generator[None, None, bool]:
    """Measure the pose of a surface by lidar and note it; return whether it was seen.

    The lidar sees a surface that is solid down to the floor. One that it does not see keeps the pose of its
    file. Distance and turn are much better known afterwards than by the base's pose on the map.

    Args:
        robot: robot before the surface.
        model: knows the surface; its entry `surface_poses` is written.
        name: name of the surface.
        report: receives the metrics `surface_off_mm` and `surface_off_deg`.
    """
    objects = model.of(Objects)
    surface = objects.objects.surfaces.get(name)
    if surface is None or robot.lidar is None or not _is_in_scan(robot, surface):
        return False
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
    others = tuple(surface_pose for surface_pose in objects.surface_poses if surface_pose.surface != name)
    if found is None:
        objects.surface_poses = others
        return False
    pose = robot.pose.compose(found.pose)
    turn = Pose2(0.0, 0.0, robot.pose.theta).lift()[:3, :3]
    covariance = turn @ found.covariance @ turn.T
    noted = SurfacePose(name, pose, tuple(tuple(row) for row in covariance.tolist()))
    objects.surface_poses = (*others, noted)
    report(
        surface_off_mm=round(1e3 * pose.distance(surface.floor), 1),
        surface_off_deg=round(math.degrees(pose.turn(surface.floor)), 2),
    )
    return True


def _is_in_scan(robot: Robot, surface: ObjectSurface) -> bool:
    """Return whether the lidar meets the sides of a surface."""
    is_solid = surface.thickness_m is None and not surface.walls
    return is_solid and robot.range_sensor_height < surface.height_m - MIN_BELOW_TOP_M


def _prior(robot: Robot, expected: Pose2) -> FloatArray:
    """Return the covariance (3, 3) of a surface's expected pose in the base frame."""
    turn = Pose2(0.0, 0.0, -robot.pose.theta).lift()[:3, :3]
    base = turn @ robot.localization.covariance @ turn.T
    by_base = np.array([[1.0, 0.0, -expected.y], [0.0, 1.0, expected.x], [0.0, 0.0, 1.0]])
    placed = np.diag([PLACED_SIGMA_M, PLACED_SIGMA_M, PLACED_SIGMA_RAD]) ** 2
    return np.asarray(by_base @ base @ by_base.T + placed)
