"""Sensor readings of a robot that drives a course outdoors."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from benchmarks.field.field_course import FieldCourse
from benchmarks.field.field_drive import PERIOD_S, FieldDrive, FieldTimes, drive_course
from handcart.robotics.geometry.transform import rotations
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.numerics.arrays import FloatArray, IntArray

GRAVITY_M_S2 = 9.81  # [m/s²]


class FieldLog(NamedTuple):
    """Readings, one row each 25 ms, and the truth beside them."""

    rates: FloatArray
    """(n, 3) of the gyros about x forward, y left, z up, in [rad/s]."""
    accelerations: FloatArray
    """(n, 3) in [m/s²]."""
    wheels: FloatArray
    """(n, 2) travel of the rear wheels, left and right, in [m]."""
    fix_rows: IntArray
    """(m,) rows after which a fix comes in."""
    fixes: FloatArray
    """(m, 2) east and north in [m]."""
    start_heading: float
    """Heading that the robot assumes at the start [rad]."""
    drive: FieldDrive
    """Ground truth, for evaluation only."""


def record_course(
    course: FieldCourse, noise: FieldNoise, seed: int, times: FieldTimes = FieldTimes()
) -> FieldLog:
    """Drive a course and record; the same seed gives the same log."""
    ground, gyro, felt, sky, wheel = (np.random.default_rng([seed, stream]) for stream in range(5))
    drive = drive_course(course, noise, ground, times)
    count = len(drive.poses)
    rows = np.arange(0, count, round(noise.gps_period / PERIOD_S))
    rows, fixes = _fixes(drive, rows, noise, sky)
    return FieldLog(
        _rates(drive, noise, gyro),
        _accelerations(drive, noise, felt),
        _travel(drive, noise, wheel),
        rows,
        fixes,
        float(noise.start_heading * gyro.standard_normal()),
        drive,
    )


def _turned(drive: FieldDrive) -> FloatArray:
    return rotations(drive.tilts[:, 0], drive.tilts[:, 1], drive.poses[:, 2])


def _rates(drive: FieldDrive, noise: FieldNoise, rng: np.random.Generator) -> FloatArray:
    """Return the (n, 3) mean turn rates of each period as the gyros measure them [rad/s]."""
    world_R_base = _turned(drive)
    step = np.einsum("nji,njk->nik", world_R_base[:-1], world_R_base[1:])  # before_R_after
    axis = np.stack(
        [step[:, 2, 1] - step[:, 1, 2], step[:, 0, 2] - step[:, 2, 0], step[:, 1, 0] - step[:, 0, 1]]
    )
    true = np.vstack([np.zeros((1, 3)), axis.T / (2.0 * PERIOD_S)])  # turns are small: sin x = x
    count = len(true)
    time = PERIOD_S * np.arange(count)[:, None]
    walk = noise.gyro_walk * math.sqrt(PERIOD_S) * np.cumsum(rng.standard_normal((count, 3)), axis=0)
    warm_up = noise.gyro_warm_up * rng.standard_normal(3) * np.exp(-time / noise.gyro_warm_up_time)
    bias = noise.gyro_bias * rng.standard_normal(3) + warm_up + walk
    white = noise.gyro_white / math.sqrt(PERIOD_S) * rng.standard_normal((count, 3))
    scale = 1.0 + noise.gyro_scale * rng.standard_normal(3)
    read: FloatArray = scale * true + bias + white
    return read


def _accelerations(drive: FieldDrive, noise: FieldNoise, rng: np.random.Generator) -> FloatArray:
    """Return (n, 3) gravity, speeding up, and vibration while driving."""
    speed = drive.driven[:, 0] / PERIOD_S
    forward = np.diff(speed, prepend=0.0) / PERIOD_S
    forces = GRAVITY_M_S2 * _turned(drive)[:, 2, :]
    forces[:, 0] += forward
    forces[:, 1] += speed**2 * drive.driven[:, 1]
    spread = np.where(
        speed > 0.0, math.hypot(noise.vibration, noise.accelerometer_white), noise.accelerometer_white
    )
    bias = noise.accelerometer_bias * rng.standard_normal(3)
    read: FloatArray = forces + bias + spread[:, None] * rng.standard_normal((len(speed), 3))
    return read


def _travel(drive: FieldDrive, noise: FieldNoise, rng: np.random.Generator) -> FloatArray:
    """Return (n, 2) what the wheels say: of the drive, of a tyre that loses air on the way, and of
    standing.
    """
    travel = drive.travel.copy()
    flat, wheel, size = int(rng.integers(len(travel) // 2)), int(rng.integers(2)), abs(rng.standard_normal())
    travel[flat:, wheel] *= 1.0 + noise.tyre * size
    if noise.creep > 0.0:
        still = drive.driven[:, 0] == 0.0
        creep = rng.standard_normal(2) + rng.standard_normal((len(travel), 2))
        travel[still] += noise.creep * PERIOD_S * creep[still]
    return travel


def _fixes(
    drive: FieldDrive, rows: IntArray, noise: FieldNoise, rng: np.random.Generator
) -> tuple[IntArray, FloatArray]:
    """Rows (m,) and positions (m, 2) of the fixes that come in."""
    measured = np.maximum(0, rows - round(noise.gps_delay / PERIOD_S))
    antenna = _turned(drive)[measured] @ np.array(noise.antenna)
    position = drive.poses[measured, :2] + antenna[:, :2]
    count = len(rows)
    keep = math.exp(-noise.gps_period / noise.gps_drift_time)
    pushes = noise.gps_drift * rng.standard_normal((count, 2))
    pushes[1:] *= math.sqrt(1.0 - keep * keep)
    drift = np.zeros((count, 2))
    for k in range(count):
        drift[k] = pushes[k] + (keep * drift[k - 1] if k else 0.0)
    reflected = _spells(count, noise.multipath_every, noise.multipath_time, noise.gps_period, rng)
    sizes = noise.multipath * rng.standard_normal((count + 1, 2))
    position = position + drift + noise.gps_white * rng.standard_normal((count, 2))
    position = position + np.where(reflected[:, None] > 0, sizes[reflected], 0.0)
    odd = rng.random(count) < noise.outliers
    position = position + noise.outlier * odd[:, None] * rng.standard_normal((count, 2))
    if not math.isinf(noise.jump_every):
        jumps = np.cumsum(rng.random(count) < noise.gps_period / noise.jump_every)
        position = position + noise.jump * rng.standard_normal((count + 1, 2))[jumps]
    heard = _spells(count, noise.outage_every, noise.outage_time, noise.gps_period, rng) == 0
    return rows[heard], position[heard]


def _spells(count: int, every: float, lasting: float, period: float, rng: np.random.Generator) -> IntArray:
    """Return (n,) number of the spell that each fix falls in, counted from 1; 0 outside."""
    number = np.zeros(count, dtype=np.int64)
    if math.isinf(every):
        return number
    time, spell = float(rng.exponential(every)), 0
    while time < count * period:
        spell += 1
        end = time + float(rng.exponential(lasting))
        number[math.ceil(time / period) : math.ceil(end / period)] = spell
        time = end + float(rng.exponential(every))
    return number
