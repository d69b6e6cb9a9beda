"""Estimate of an IMU's mounting, from gravity and from the turns of the wheels' odometry."""

from __future__ import annotations

import math
from itertools import permutations, product
from typing import NamedTuple

import numpy as np

from handcart.evaluation.offline_localization.logs.csv_log import held_on
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.numerics.arrays import FloatArray

MAX_TILT_DEG = 20.0  # between the IMU's z axis and gravity
MIN_FORCE = 5.0  # [m/s2] of measured gravity; less: the IMU subtracts it
MIN_TURNS = 0.02  # [rad/s] standard deviation of the turns by which gyros are compared
ALIKE, UNLIKE = 0.5, 0.3  # correlation of a gyro axis that turns with the wheels, and of one that does not
SMOOTHED_S = 1.0
AXIS_NAMES = "xyz"


class Mount(NamedTuple):
    """Estimated orientation of an IMU on the base."""

    base_R_imu: FloatArray
    """(3, 3) rotation from the IMU's to the base's frame."""
    axes: str
    """The IMU's axes that point forward, left and up, in the notation of `--imu-axes`."""
    words: str
    """Evidence that it is not mounted in the base's axes; empty if it is."""


def check_mount(log: DriveLog) -> Mount:
    """Estimate how an IMU is mounted, from gravity and from the turns measured by the wheels."""
    force = np.nanmedian(log.accelerations, axis=0)
    alike = _correlations(log)
    up, why = _up(force, alike)
    if not why:
        return Mount(np.eye(3), "x,y,z", "")
    turned = _nearest(up, force, log)
    axes = ",".join(
        f"{'-' if row.min() < -0.5 else ''}{AXIS_NAMES[int(np.argmax(np.abs(row)))]}" for row in turned
    )
    return Mount(_levelling(turned @ up) @ turned, axes, why)


def mounted(log: DriveLog, base_R_imu: FloatArray) -> DriveLog:
    """Return a copy of a log with the IMU's readings rotated into the base's axes.

    Args:
        log: log with readings in the IMU's axes.
        base_R_imu: (3, 3) rotation from the IMU's to the base's axes.
    """
    return log._replace(rates=log.rates @ base_R_imu.T, accelerations=log.accelerations @ base_R_imu.T)


def axes_rotation(axes: str) -> FloatArray | None:
    """Return the rotation base_R_imu (3, 3) of an IMU whose axes are given as text; None for invalid axes.

    Args:
        axes: the IMU's axes that point forward, left and up, such as `z,-x,y`; they must form a right-handed
            frame.
    """
    rows = []
    for axis in axes.split(","):
        name = axis.strip().removeprefix("-")
        if len(name) != 1 or name not in AXIS_NAMES:
            return None
        rows.append((-1.0 if axis.strip().startswith("-") else 1.0) * np.eye(3)[AXIS_NAMES.index(name)])
    turned = np.array(rows)
    return turned if turned.shape == (3, 3) and abs(np.linalg.det(turned) - 1.0) < 1e-9 else None


def _up(force: FloatArray, alike: FloatArray | None) -> tuple[FloatArray, str]:
    """Return the upward direction (3,) in the IMU's frame, and the evidence that this is not its z axis.

    Args:
        force: (3,) mean acceleration, in [m/s²].
        alike: (3,) correlation of each gyro axis with the odometry's turns; None if unknown.
    """
    size, up, by_force = float(np.linalg.norm(force)), np.array([0.0, 0.0, 1.0]), ""
    if size > MIN_FORCE:
        up = force / size
        if math.degrees(math.acos(min(1.0, float(up[2])))) > MAX_TILT_DEG:
            by_force = (
                f"gravity is along its {_named(up)} axis ({np.abs(force).max():.1f} of {size:.1f} m/s2)"
            )
    if alike is None:
        return up, f"the IMU isn't mounted like the base: {by_force}" if by_force else ""
    shares = ", ".join(f"{AXIS_NAMES[k]} {alike[k]:.2f}" for k in range(3))
    by_turns = f"its gyros turn with the wheels by correlations of {shares}"
    if float(up @ alike) < -ALIKE:
        up = -up
        by_force = "" if up[2] > 0.9 else by_force or "it is upside down"
        why = "; ".join(filter(None, (by_force, by_turns)))
        return up, f"the IMU isn't mounted like the base: {why}" if up[2] < 0.9 else ""
    if by_force:
        return up, f"the IMU isn't mounted like the base: {by_force}; {by_turns}"
    best = int(np.argmax(np.abs(alike)))
    if alike[2] < UNLIKE and abs(alike[best]) > ALIKE:
        up = math.copysign(1.0, alike[best]) * np.eye(3)[best]
        return up, f"the IMU isn't mounted like the base: {by_turns}"
    return up, ""


def _named(up: FloatArray) -> str:
    axis = int(np.argmax(np.abs(up)))
    return f"{'-' if up[axis] < 0.0 else '+'}{AXIS_NAMES[axis]}"


def _correlations(log: DriveLog) -> FloatArray | None:
    """Return the correlation (3,) of each gyro axis with the odometry's turns; None without usable turns."""
    if log.odometry_turns is None or log.steered:
        return None
    turns = _smooth(log.times, held_on(log.odometry_turns))
    if float(turns.std()) < MIN_TURNS:
        return None
    rates = np.stack([_smooth(log.times, held_on(rate)) for rate in log.rates.T])
    spread = np.maximum(rates.std(axis=1), 1e-9)
    away = rates - rates.mean(axis=1, keepdims=True)
    return np.asarray(away @ (turns - turns.mean()) / len(turns) / spread / turns.std())


def _smooth(times: FloatArray, values: FloatArray) -> FloatArray:
    """Return values (n,) at times (n,) in [s], averaged over about `SMOOTHED_S`."""
    step = float(times[-1] - times[0]) / max(1, len(times) - 1)
    count = max(1, min(len(values), round(SMOOTHED_S / max(step, 1e-6))))
    return np.asarray(np.convolve(values, np.ones(count) / count, mode="same"), dtype=np.float64)


def _nearest(up: FloatArray, force: FloatArray, log: DriveLog) -> FloatArray:
    """Return base_R_imu (3, 3) of quarter turns that has `up` (3,) upwards, and forward where the vehicle
    accelerates.

    Args:
        up: (3,) upward direction in the IMU's frame.
        force: (3,) mean acceleration in the IMU's frame, in [m/s²].
        log: log with accelerations and wheels.
    """
    candidates = [
        turned
        for signs in product((1.0, -1.0), repeat=3)
        for order in permutations(range(3))
        if abs(np.linalg.det(turned := np.diag(signs) @ np.eye(3)[list(order)]) - 1.0) < 1e-9
        and float(turned[2] @ up) > 0.7
    ]
    way = np.nan_to_num(log.wheels.mean(axis=1))
    steps = np.diff(log.times, prepend=log.times[0])
    speeds = _smooth(log.times, np.divide(way, steps, out=np.zeros(len(way)), where=steps > 0.0))
    gained = np.gradient(speeds)
    felt = np.stack([_smooth(log.times, held_on(item)) for item in log.accelerations.T], axis=1)
    along = np.array(
        [float(np.nan_to_num(gained) @ (felt @ turned[0] - force @ turned[0])) for turned in candidates]
    )
    best: FloatArray = candidates[int(np.argmax(along + 1e-9 * np.trace(candidates, axis1=1, axis2=2)))]
    return best


def _levelling(up: FloatArray) -> FloatArray:
    """Return the smallest rotation (3, 3) that turns `up` (3,) to the z axis (Rodrigues)."""
    axis, cos = np.cross(up, [0.0, 0.0, 1.0]), float(up[2])
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: FloatArray = np.eye(3) + skew + skew @ skew / (1.0 + cos)
    return turned
