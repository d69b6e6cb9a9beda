"""Scans and poses that a run of handcart recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.files.errors import FileError, Finding
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.scan_log import ScanLog

from .odometry_track import poses_at

ODOMETRY_NOTE = "a run records its estimated poses, not the wheels: they are taken as odometry"


def read_run_scans(folder: Path) -> ScanLog:
    """Read the scans in a run's folder; its estimated poses are taken as odometry.

    Raises:
        NoRun: the folder holds no run, or no recording.
        FileError: fewer than two scans were recorded, for example because the robot has no lidar.
    """
    recorded = Playback.read(folder)
    robot, rows = recorded.scenery.robot, recorded.rows
    if len(rows.scan_time) < 2 or len(robot.angles_rad) != rows.scan_mm.shape[1]:
        wrong = "fewer than two scans were recorded in it; needed: a robot with a lidar that drove"
        raise FileError([Finding(str(folder), 0, 0, wrong)])
    poses, near = poses_at(rows.scan_time, rows.time, rows.pose)
    ranges = np.array([recorded.ranges(number) for number in range(len(rows.scan_time))])[near]
    reach = float(np.max(ranges[np.isfinite(ranges)], initial=1.0))
    mount = Pose2(*robot.base_t_sensor)
    return ScanLog(
        rows.scan_time[near], poses[near], np.array(robot.angles_rad), ranges, mount, reach, (ODOMETRY_NOTE,)
    )
