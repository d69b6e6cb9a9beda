"""Rays of a range sensor, as lines in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.evaluation.playback.scenery import RobotShape
from handcart.evaluation.playback.seven import transforms
from handcart.robotics.geometry.transform import transform

Array = NDArray[np.float64]
HEIGHT = 0.25  # of the sensor above the floor, where the robot's URDF doesn't tell [m]


def rays_of(robot: RobotShape, ranges: Array, base: Array, height: float) -> Array:
    """Lines of a scan.

    Args:
        robot: whose sensor it is.
        ranges: (b,) in [m]; what is no distance hit nothing.
        base: (7,) world_T_base.
        height: of the sensor above the base's frame, in [m].

    Returns:
        (n, 2, 3) in [m] in the world: from the sensor to what was hit.
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
    """Of the link `range_sensor` in the link `base`, in [m]."""
    from handcart.robotics.kinematics.urdf_frames import base_T_frame

    try:
        return float(base_T_frame(urdf, "range_sensor")[2, 3])
    except ValueError:
        return HEIGHT
