"""Lidar rays as lines in the world."""

from __future__ import annotations

import numpy as np

from handcart.evaluation.viewing.playback.scenery import RobotShape
from handcart.evaluation.viewing.playback.seven import transforms
from handcart.robotics.geometry.transform import transform
from handcart.robotics.numerics.arrays import FloatArray

DEFAULT_HEIGHT_M = 0.25  # of the lidar above the floor, if the URDF has no frame for it


def rays_of(robot: RobotShape, ranges: FloatArray, base: FloatArray, height: float) -> FloatArray:
    """Return the rays of a lidar scan that hit something.

    Args:
        robot: shape of the robot, with the lidar's mounting.
        ranges: (b,) ranges of the scan, in [m]; a beam with an infinite or NaN range hit nothing.
        base: (7,) world_T_base: x, y, z in [m], and a unit quaternion w, x, y, z.
        height: height of the lidar above the base's frame, in [m].

    Returns:
        Rays (n, 2, 3), each from the lidar to the point that was hit, in the world, in [m].
    """
    x, y, heading = robot.base_t_sensor
    hit = np.isfinite(ranges)
    angles = np.array(robot.angles_rad)[: len(ranges)]
    reach, angles = ranges[hit], angles[hit]
    ends = np.column_stack((reach * np.cos(angles), reach * np.sin(angles), np.zeros(len(reach))))
    world_T_sensor = transforms(base[None])[0] @ transform((x, y, height), (0.0, 0.0, heading))
    lines = np.empty((len(ends), 2, 3))
    lines[:, 0] = world_T_sensor[:3, 3]
    lines[:, 1] = ends @ world_T_sensor[:3, :3].T + world_T_sensor[:3, 3]
    return lines


def height_of(urdf: str) -> float:
    """Return the height in [m] of the link `range_sensor` above the link `base`, by a robot's URDF.

    It is `DEFAULT_HEIGHT_M` if the URDF has no such links.
    """
    from handcart.robotics.kinematics.urdf_frames import base_T_frame

    try:
        return float(base_T_frame(urdf, "range_sensor")[2, 3])
    except ValueError:
        return DEFAULT_HEIGHT_M
