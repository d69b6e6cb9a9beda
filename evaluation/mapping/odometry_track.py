"""Odometry poses over time, read between their messages."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

MAX_GAP_S = 1.0
"""Distance in time of a scan from the nearest odometry beyond which it is skipped."""


def poses_at(times: FloatArray, track_times: FloatArray, track: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the odometry's pose, interpolated, at the time of each scan.

    Args:
        times: (n,) times of the scans, in [s].
        track_times: (m,) times of the odometry, in [s], in any order.
        track: (m, 3) odom_T_base: x, y in [m], heading in [rad].

    Returns:
        odom_T_base (n, 3), in [m, m, rad], and a mask (n,), True where a reading of the odometry is at most
        `MAX_GAP_S` from the scan.
    """
    order = np.argsort(track_times, kind="stable")
    known, track = track_times[order], track[order]
    heading = np.unwrap(track[:, 2])
    columns = [np.interp(times, known, values) for values in (track[:, 0], track[:, 1], heading)]
    poses = np.stack(columns, axis=1)
    poses[:, 2] = np.arctan2(np.sin(poses[:, 2]), np.cos(poses[:, 2]))
    after = (
        np.searchsorted(known, times).clip(1, len(known) - 1) if len(known) > 1 else np.zeros(len(times), int)
    )
    nearest = np.minimum(np.abs(times - known[after - 1]), np.abs(times - known[after]))
    return poses, nearest <= MAX_GAP_S
