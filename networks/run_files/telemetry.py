"""Poses of the robot in each period, kept only to draw them."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from handcart.files.whole_file import write_whole
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Int32Array

if TYPE_CHECKING:
    from handcart.backends.robot.robot import Robot


class RunTrack(NamedTuple):
    """A run, period by period."""

    time: FloatArray
    """(n,) the robot's time, in [s]."""
    pose: FloatArray
    """(n, 3) estimated map_T_base: x and y in [m], heading in [rad]."""
    action: Int32Array
    """(n,) number of the action that ran, from 1; 0 before the first."""
    restoring: BoolArray
    """(n,) whether it restored."""


class Telemetry:
    """Recorder of the robot's poses, period by period."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, float, float, int, bool]] = []

    def record(self, robot: Robot, action: int, restoring: bool) -> None:
        """Record the robot's present pose."""
        pose = robot.pose
        self._rows.append((robot.time, pose.x, pose.y, pose.theta, action, restoring))

    def track(self) -> RunTrack:
        """Return the poses recorded so far."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, 6)
        return RunTrack(table[:, 0], table[:, 1:4], table[:, 4].astype(np.int32), table[:, 5] > 0.5)

    def save(self, path: Path) -> None:
        """Write the track into an .npz file."""
        packed = BytesIO()
        np.savez_compressed(packed, **self.track()._asdict())
        write_whole(path, packed.getvalue())


def load_track(file: Path | BytesIO) -> RunTrack:
    """Load a saved track."""
    with np.load(file, allow_pickle=False) as arrays:
        return RunTrack(**{name: arrays[name] for name in RunTrack._fields})
