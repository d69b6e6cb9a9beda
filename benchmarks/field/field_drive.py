"""True motion of a base with front steering that drives a course over rough ground."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from benchmarks.field.field_course import POINT_SPACING_M, FieldCourse
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_CURVATURE, FieldNoise
from handcart.robotics.numerics.arrays import FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled

PERIOD_S = 0.025  # [s]
LOOKAHEAD_M = 1.5  # [m] at which pure pursuit looks
CREEP_SPEED_M_S = 0.02  # [m/s], the last centimetre of a leg


class FieldTimes(NamedTuple):
    """Times at which the base moves and stops."""

    speed: float = 0.5
    """Speed [m/s]."""
    acceleration: float = 0.3
    """Acceleration [m/s²]."""
    wait: float = 60.0
    """At rest before the first leg, in [s]."""
    dwell: float = 40.0
    """At rest at each target, in [s]."""
    placing: float = 10.0
    """Time from the stop to the release [s]."""


class FieldDrive(NamedTuple):
    """The truth, one row each 25 ms."""

    poses: FloatArray
    """(n, 3): x, y in [m], heading in [rad], of the rear axle's middle."""
    tilts: FloatArray
    """(n, 2): roll and pitch in [rad]."""
    travel: FloatArray
    """(n, 2) readings of the rear wheels, left and right, for the period that ends with the row [m]."""
    driven: FloatArray
    """(n, 2): of that period, way really driven in [m] and curvature in [1/m]."""
    placings: IntArray
    """(k,) rows at which a sensor is let go."""


def drive_course(
    course: FieldCourse,
    noise: FieldNoise,
    rng: np.random.Generator,
    times: FieldTimes = FieldTimes(),
    tread: float = 0.6,
) -> FieldDrive:
    """Drive a course by pure pursuit of the true pose; `tread` of the rear wheels in [m]."""
    length = POINT_SPACING_M * len(course.line)
    ramps = len(course.stops) * 2.0 * times.speed / times.acceleration
    rest = times.wait + times.dwell * len(course.stops)
    rows = int((rest + 1.5 * length / times.speed + 2.0 * ramps + 60.0) / PERIOD_S)
    shape = np.array([noise.roughness, noise.roughness_length, noise.slip, noise.slip_length])
    turning = np.array([noise.turn_slip, noise.side_slip, noise.side_slip_length, noise.side_slip_turning])
    scale = noise.scale * rng.standard_normal()
    out = np.zeros((rows, 9))
    count, placings = _drive(
        out, course.line, course.stops, np.array(times), shape, turning, scale, tread, rng
    )
    out = out[:count]
    return FieldDrive(out[:, :3], out[:, 3:5], out[:, 5:7], out[:, 7:9], placings)


@compiled
def _drift(value: float, share: float, sigma: float, rng: np.random.Generator) -> float:
    """Return an Ornstein-Uhlenbeck value after `share` of its length."""
    keep = math.exp(-share)
    return keep * value + sigma * math.sqrt(1.0 - keep * keep) * float(rng.standard_normal())


@compiled
def _curvature(pose: FloatArray, point: FloatArray) -> float:
    """Pure pursuit of a point, within what the steering can do (Coulter, 1992)."""
    dx, dy = point[0] - pose[0], point[1] - pose[1]
    left = -math.sin(pose[2]) * dx + math.cos(pose[2]) * dy
    return float(min(REFERENCE_CURVATURE, max(-REFERENCE_CURVATURE, 2.0 * left / (dx * dx + dy * dy))))


@compiled
def _next_speed(speed: float, top: float, acceleration: float, left_over: float) -> float:
    """Return the speed of the next period, from which the vehicle can stop at the end of its way."""
    braking = max(CREEP_SPEED_M_S, math.sqrt(2.0 * acceleration * left_over))
    return min(top, speed + acceleration * PERIOD_S, braking)


@compiled
def _drive(
    out: FloatArray,
    line: FloatArray,
    stops: IntArray,
    times: FloatArray,
    shape: FloatArray,
    turning: FloatArray,
    scale: float,
    tread: float,
    rng: np.random.Generator,
) -> tuple[int, IntArray]:
    """Rows (x, y, heading, roll, pitch, left, right, way, curvature) into `out`; how many; the placings."""
    top, acceleration, wait, dwell, placing = times
    pose = np.zeros(3)
    waves = math.sqrt(2.0) * shape[0] * rng.standard_normal(2)
    tilt = waves / 2.0
    slip, side = shape[2] * rng.standard_normal(), turning[1] * rng.standard_normal()
    placings = np.zeros(len(stops), dtype=np.int64)
    row, at = 0, 0
    for _ in range(round(wait / PERIOD_S)):
        out[row, 3:5] = tilt
        row += 1
    for leg in range(len(stops)):
        turn_slip = turning[0] * rng.standard_normal()
        speed, stop = 0.0, stops[leg]
        while True:
            while at < stop and _nearer(pose, line, at):
                at += 1
            ahead = line[min(stop, at + round(LOOKAHEAD_M / POINT_SPACING_M))]
            beyond = math.hypot(line[stop, 0] - pose[0], line[stop, 1] - pose[1])
            left_over = (stop - at) * POINT_SPACING_M if at < stop - 2 else _along(pose, line, stop)
            if left_over <= 0.0 or row >= len(out) - round(dwell / PERIOD_S) - 1:
                break
            if beyond < LOOKAHEAD_M:
                ahead = line[stop] + LOOKAHEAD_M * (line[stop] - line[stop - 1]) / POINT_SPACING_M
            speed = _next_speed(speed, top, acceleration, left_over)
            way, bend = speed * PERIOD_S, _curvature(pose, ahead)
            for axis in range(2):
                waves[axis] = _drift(waves[axis], way / shape[1], math.sqrt(2.0) * shape[0], rng)
                tilt[axis] += (1.0 - math.exp(-way / shape[1])) * (waves[axis] - tilt[axis])
            slip = _drift(slip, way / shape[3], shape[2], rng)
            side = _drift(side, way / turning[2], turning[1], rng)
            course = pose[2] + 0.5 * way * bend + side + turning[3] * bend
            pose[0] += way * math.cos(tilt[1]) * math.cos(course)
            pose[1] += way * math.cos(tilt[1]) * math.sin(course)
            pose[2] += way * bend
            rolled = way * (1.0 + scale + slip + turn_slip * abs(bend) / REFERENCE_CURVATURE)
            out[row, :3], out[row, 3:5] = pose, tilt
            out[row, 5], out[row, 6] = (
                rolled * (1.0 - 0.5 * bend * tread),
                rolled * (1.0 + 0.5 * bend * tread),
            )
            out[row, 7], out[row, 8] = way, bend
            row += 1
        placings[leg] = row + round(placing / PERIOD_S)
        for _ in range(round(dwell / PERIOD_S)):
            out[row, :3], out[row, 3:5] = pose, tilt
            row += 1
    return row, placings


@compiled
def _nearer(pose: FloatArray, line: FloatArray, at: int) -> bool:
    """Return True if the next point of the line is nearer than this one."""
    here = (line[at, 0] - pose[0]) ** 2 + (line[at, 1] - pose[1]) ** 2
    return bool((line[at + 1, 0] - pose[0]) ** 2 + (line[at + 1, 1] - pose[1]) ** 2 < here)


@compiled
def _along(pose: FloatArray, line: FloatArray, stop: int) -> float:
    """Way left to the stop along the line's last piece, in [m]."""
    ux, uy = (
        (line[stop, 0] - line[stop - 1, 0]) / POINT_SPACING_M,
        (line[stop, 1] - line[stop - 1, 1]) / POINT_SPACING_M,
    )
    return float(ux * (line[stop, 0] - pose[0]) + uy * (line[stop, 1] - pose[1]))
