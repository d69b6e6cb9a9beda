"""Poses of the robot in each period, kept only to draw them."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from handcart.files.whole_file import write_whole
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Int32Array

if TYPE_CHECKING:
    from handcart.backends.robot.robot import Robot


class RunTrack(NamedTuple):
    """Pose of the robot and number of its action in each control period of a run."""

    time: FloatArray
    """(n,) the robot's time, in [s]."""
    pose: FloatArray
    """(n, 3) estimated map_T_base: x and y in [m], heading in [rad].

    Poses from before the robot was located are computed from its pose afterwards; NaN if it never was.
    """
    action: Int32Array
    """(n,) number of the action that ran, from 1; 0 before the first."""
    restoring: BoolArray
    """(n,) True while the action was being restored."""


class Telemetry:
    """Recorder of the robot's pose and action in each control period of a run."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, float, float, int, bool]] = []
        self._located: list[bool] = []

    def record(self, robot: Robot, action: int, restoring: bool) -> None:
        """Record the robot's present pose for this period.

        Args:
            robot: the robot.
            action: number of the action that runs, from 1; 0 before the first.
            restoring: True if the action is restoring what it changed.
        """
        pose = robot.pose
        self._rows.append((robot.time, pose.x, pose.y, pose.theta, action, restoring))
        self._located.append(robot.localization.is_located)

    def track(self) -> RunTrack:
        """Return the times, poses and actions of the run recorded so far.

        The poses are in the map frame if the robot came to know its pose on the map; see `on_the_map`.
        """
        table = np.array(self._rows, dtype=np.float64).reshape(-1, 6)
        poses = on_the_map(table[:, 1:4], np.array(self._located, dtype=np.bool_))
        return RunTrack(table[:, 0], poses, table[:, 4].astype(np.int32), table[:, 5] > 0.5)

    def save(self, path: Path) -> None:
        """Write the recorded poses and actions (`track`) into an .npz file."""
        packed = BytesIO()
        np.savez_compressed(packed, **self.track()._asdict())
        write_whole(path, packed.getvalue())


def on_the_map(poses: FloatArray, located: BoolArray) -> FloatArray:
    """Return poses on the map, given poses of which some are in a local frame.

    Before a robot is located on the map, its poses are in a local frame. It is located at rest, and its pose
    then jumps into the map frame; this jump shows the local frame's pose on the map.

    Args:
        poses: (n, 3) x and y in [m], heading in [rad].
        located: (n,) whether each pose is on the map already.

    Returns:
        (n, 3) poses on the map; NaN if the robot was not located afterwards.
    """
    found = poses.copy()
    ends = np.flatnonzero(np.diff(located.astype(np.int8)))
    begins = np.concatenate([[0], ends + 1]) if len(located) else np.empty(0, dtype=np.int64)
    for begin, end in zip(begins, np.append(ends + 1, len(located)), strict=False):
        if located[begin]:
            continue
        found[begin:end] = np.nan
        if end < len(located):
            map_T_local = Pose2(*poses[end].tolist()).compose(Pose2(*poses[end - 1].tolist()).inverse())
            found[begin:end] = [map_T_local.compose(Pose2(*pose)) for pose in poses[begin:end].tolist()]
    return found


def load_track(file: Path | BytesIO) -> RunTrack:
    """Load the saved track of a run, which has the robot's pose and action in each control period."""
    with np.load(file, allow_pickle=False) as arrays:
        return RunTrack(**{name: arrays[name] for name in RunTrack._fields})
