"""Logs of vehicles that the filters know nothing of: a lawn mower, a truck, a skid-steer robot.

They break what filters and simulations usually share. Fixes err by a heavy-tailed white part, by slow parts
of two time constants and by jumps that last some seconds, wheels spin in bursts and scrub in turns, and gyros
drift with a temperature of their own. None of these figures is in `FieldNoise`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.numerics.arrays import FloatArray, IntArray

PERIOD_S = 0.05  # [s]
GRAVITY_M_S2 = 9.81
SIDEWAYS_IMU = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""imu_R_base of the skid-steer robot: its y axis points up."""


class Receiver(NamedTuple):
    """Errors of the fixes."""

    period: float
    """Time between fixes [s]."""
    white: float
    """An axis, in [m]; its tails are those of Student's t with 5 degrees of freedom."""
    slow: tuple[tuple[float, float], ...]
    """Sigma an axis [m] and time constant [s] of each slow part."""
    jump_every: float = math.inf
    """Mean time between jumps, in [s]."""
    jump: float = 3.5
    """Mean size of a jump, in [m]."""
    jump_time: float = 6.0
    """Mean time that a jump lasts, in [s]."""
    stated: float = math.nan
    """Sigma that it states for each fix, per axis [m]; NaN: it states none."""


class Vehicle(NamedTuple):
    """Motion of a vehicle, and the errors of its wheels and gyros."""

    speed: float
    """Speed [m/s]."""
    scale: float
    """Relative error of the wheels' travel; one sigma."""
    spin: float
    """Share by which the wheels turn too far in a burst."""
    spin_every: float
    """Mean time between bursts, in [s]."""
    scrub: float
    """Share of the way that is lost per 1/m of curvature."""
    turn_factor: float
    """Times the true turn that the wheels' odometry says."""
    gyro_bias: float
    """Bias of the gyros [rad/s]; one sigma."""
    receiver: Receiver
    is_sideways: bool = False
    """True if its IMU is mounted as `SIDEWAYS_IMU`."""


class ForeignLog(NamedTuple):
    """A log, and what is only known in simulation."""

    log: DriveLog
    jumps: FloatArray
    """(n,) size of the jump that lasts at each row's fix, in [m]; 0 outside jumps."""


MOWER_VEHICLE = Vehicle(
    speed=1.1,
    scale=0.02,
    spin=0.25,
    spin_every=40.0,
    scrub=0.05,
    turn_factor=1.0,
    gyro_bias=math.radians(0.5),
    receiver=Receiver(1.0, 0.6, ((0.8, 15.0), (1.0, 120.0)), jump_every=90.0, jump=2.0),
)
TRUCK_VEHICLE = Vehicle(
    speed=7.0,
    scale=0.015,
    spin=0.1,
    spin_every=60.0,
    scrub=0.0,
    turn_factor=1.0,
    gyro_bias=math.radians(0.3),
    receiver=Receiver(0.2, 0.4, ((0.6, 20.0), (1.0, 200.0)), jump_every=25.0, jump=4.0, jump_time=5.0),
)
SKID_VEHICLE = Vehicle(
    speed=0.9,
    scale=0.03,
    spin=0.3,
    spin_every=30.0,
    scrub=0.15,
    turn_factor=1.5,
    gyro_bias=math.radians(0.8),
    receiver=Receiver(1.0, 0.7, ((0.9, 10.0), (0.8, 60.0))),
    is_sideways=True,
)
ALL_VEHICLES = {"mower": MOWER_VEHICLE, "truck": TRUCK_VEHICLE, "skid": SKID_VEHICLE}


def record_foreign(name: str, seed: int, duration: float = 300.0) -> ForeignLog:
    """Record a drive; the same seed gives the same log.

    Args:
        name: of a vehicle in `VEHICLES`.
        seed: of course and errors.
        duration: in [s].
    """
    vehicle, rng = ALL_VEHICLES[name], np.random.default_rng([seed, len(name)])
    count = round(duration / PERIOD_S)
    speeds, turns = _COURSES[name](vehicle, count, rng)
    poses = _drive(speeds, turns, rng)
    times: FloatArray = np.asarray(PERIOD_S * np.arange(count), dtype=np.float64)
    spins = _spells(count, vehicle.spin_every, 1.5, rng) > 0
    slips = 1.0 + vehicle.spin * spins + vehicle.scrub * np.abs(turns) / np.maximum(speeds, 0.3)
    scale = 1.0 + vehicle.scale * rng.standard_normal()
    read = speeds * slips * scale * (1.0 + 0.01 * rng.standard_normal(count))
    rates, felt = _inertial(vehicle, speeds, turns, rng)
    fixes, jumps = _fixes(vehicle.receiver, poses, rng)
    stated = np.where(np.isfinite(fixes[:, 0]), vehicle.receiver.stated, math.nan)
    travel = PERIOD_S * read
    wheel_turns = vehicle.turn_factor * turns + 0.02 * rng.standard_normal(count)
    log = DriveLog(
        times,
        rates,
        felt,
        np.stack([travel, travel], axis=1),
        fixes,
        stated,
        poses,
        (math.nan,) * 3,
        None,
        odometry_turns=wheel_turns,
    )
    return ForeignLog(log, jumps)


def _drive(speeds: FloatArray, turns: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the poses (n, 3) from a start that is drawn."""
    headings = rng.uniform(-math.pi, math.pi) + PERIOD_S * np.cumsum(turns)
    x = rng.uniform(-20.0, 20.0) + PERIOD_S * np.cumsum(speeds * np.cos(headings))
    y = rng.uniform(-20.0, 20.0) + PERIOD_S * np.cumsum(speeds * np.sin(headings))
    return np.stack([x, y, headings], axis=1)


def _legs(vehicle: Vehicle, legs: list[tuple[float, float]], count: int) -> tuple[FloatArray, FloatArray]:
    """Return speeds and turn rates (n,) of legs: how long in [s], and how fast it turns in [rad/s]."""
    turns = np.concatenate([np.full(max(1, round(time / PERIOD_S)), rate) for time, rate in legs])[:count]
    turns = np.pad(turns, (0, count - len(turns)))
    kernel = np.ones(10) / 10.0
    return np.full(count, vehicle.speed), np.convolve(turns, kernel, mode="same")


def _mown(vehicle: Vehicle, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return speeds and turn rates of lanes back and forth with half turns, after a short rest."""
    legs, side = list[tuple[float, float]](), 1.0
    length = rng.uniform(18.0, 30.0)
    while sum(time for time, _ in legs) < PERIOD_S * count:
        legs += [(length / vehicle.speed, rng.normal(0.0, 0.01)), (math.pi / 0.8, 0.8 * side)]
        side = -side
    speeds, turns = _legs(vehicle, legs, count)
    speeds = np.where(np.abs(turns) > 0.4, 0.6 * speeds, speeds)
    still = round(3.0 / PERIOD_S)
    speeds[:still], turns[:still] = 0.0, 0.0
    return speeds, turns


def _on_roads(vehicle: Vehicle, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Roads with bends and crossings; it drives from the first row on."""
    legs = list[tuple[float, float]]()
    while sum(time for time, _ in legs) < PERIOD_S * count:
        bend = rng.choice((-1.0, 1.0)) * rng.uniform(0.2, 0.35)
        legs += [(rng.uniform(8.0, 30.0), rng.normal(0.0, 0.01)), (rng.uniform(3.0, 6.0), bend)]
    speeds, turns = _legs(vehicle, legs, count)
    times = PERIOD_S * np.arange(count)
    speeds = speeds * (0.75 + 0.25 * np.sin(2.0 * math.pi * times / 45.0 + rng.uniform(0.0, 6.0)))
    return np.where(np.abs(turns) > 0.1, np.minimum(speeds, 4.0), speeds), turns


def _about(vehicle: Vehicle, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Short ways between turns on the spot; it drives from the first row on."""
    legs = list[tuple[float, float]]()
    while sum(time for time, _ in legs) < PERIOD_S * count:
        angle = rng.choice((-1.0, 1.0)) * rng.uniform(0.4, 1.8)
        legs += [
            (rng.uniform(6.0, 18.0), rng.normal(0.0, 0.02)),
            (abs(angle) / 0.6, math.copysign(0.6, angle)),
        ]
    speeds, turns = _legs(vehicle, legs, count)
    return np.where(np.abs(turns) > 0.3, 0.2 * speeds, speeds), turns


_COURSES = {"mower": _mown, "truck": _on_roads, "skid": _about}


def _inertial(
    vehicle: Vehicle, speeds: FloatArray, turns: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return rates and accelerations (n, 3) as the IMU reads them in its own axes."""
    count = len(speeds)
    warm = np.exp(-PERIOD_S * np.arange(count) / 200.0)
    bias = vehicle.gyro_bias * (rng.standard_normal(3) + 0.4 * warm[:, None] * rng.standard_normal(3))
    shaken = np.where(speeds > 0.0, 1.0, 0.05)[:, None]
    rates = np.stack([np.zeros(count), np.zeros(count), turns], axis=1)
    rates = rates + bias + np.radians(0.3) * shaken * rng.standard_normal((count, 3))
    forward = np.gradient(speeds, PERIOD_S)
    felt = np.stack([forward, speeds * turns, np.full(count, GRAVITY_M_S2)], axis=1)
    felt = felt + 0.6 * shaken * rng.standard_normal((count, 3))
    turned = SIDEWAYS_IMU if vehicle.is_sideways else np.eye(3)
    return rates @ turned.T, felt @ turned.T


def _fixes(receiver: Receiver, poses: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return the fixes (n, 2), NaN where none comes in, and the jump that each is off by (n,)."""
    count, every = len(poses), round(receiver.period / PERIOD_S)
    away = receiver.white * rng.standard_t(5, (count, 2)) * math.sqrt(3.0 / 5.0)
    for sigma, time in receiver.slow:
        away += _slow(count, sigma, time, rng)
    number = _spells(count, receiver.jump_every, receiver.jump_time, rng)
    sizes = rng.exponential(receiver.jump, number.max() + 1)
    angles = rng.uniform(-math.pi, math.pi, number.max() + 1)
    sizes[0] = 0.0
    jumps = sizes[number]
    away += np.stack([jumps * np.cos(angles[number]), jumps * np.sin(angles[number])], axis=1)
    fixes = np.full((count, 2), math.nan)
    rows = np.arange(0, count, every)
    fixes[rows] = poses[rows, :2] + away[rows]
    return fixes, jumps


def _slow(count: int, sigma: float, time: float, rng: np.random.Generator) -> FloatArray:
    """Return (n, 2) of an error that forgets itself over `time` [s]."""
    from scipy.signal import lfilter

    keep = math.exp(-PERIOD_S / time)
    pushes = sigma * math.sqrt(1.0 - keep * keep) * rng.standard_normal((count, 2))
    pushes[0] = sigma * rng.standard_normal(2)
    return np.asarray(lfilter([1.0], [1.0, -keep], pushes, axis=0))


def _spells(count: int, every: float, lasting: float, rng: np.random.Generator) -> IntArray:
    """Return (n,) the number of the spell at each row, counted from 1; 0 outside."""
    number = np.zeros(count, dtype=np.int64)
    if math.isinf(every):
        return number
    time, spell = float(rng.exponential(every)), 0
    while time < count * PERIOD_S:
        spell += 1
        end = time + 0.5 + float(rng.exponential(lasting))
        number[math.ceil(time / PERIOD_S) : math.ceil(end / PERIOD_S)] = spell
        time = end + float(rng.exponential(every))
    return number
