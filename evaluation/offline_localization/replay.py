"""Replay of a recorded log to a robot's outdoor localization."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from handcart.evaluation.offline_localization.checks.jump_gate import JumpGate
from handcart.evaluation.offline_localization.logs.drive_log import MIN_PERIOD_SHARE, DriveLog
from handcart.files.errors import InputError
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.beacons.beacon_filter import BeaconFilter
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.noise_hypotheses import noise_hypotheses
from handcart.robotics.navigation.outdoors.particle_filter import ParticleErrors, ParticleFilter
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

TRACK_PERIOD_S = 1.0  # between points of the track
CLOUD_COUNT = 5  # instants with recorded particles: as in figure 3 of Ohki et al. (2012)
HEADING_SIGMA = math.radians(10.0)  # below which a heading counts as known
PARTICLES_SIGMA = math.radians(20.0)  # the limit for particles, which never estimate a gyro's bias
LASTS_S = 2.0  # for which a bias turns the particles before fixes correct them
SLOW_COUNTS = 2.5  # weight of the slow error in the particle filter's error of a fix
START_SIGMAS = 3.0  # uncertainty of the start, in sigmas of the first fix
STEERED_NOISE: dict[str, Any] = {
    "gyro_white": math.radians(0.5),
    "gyro_bias": math.radians(0.2),
    "gyro_scale": 0.05,
}
"""Noise of turn rates that come from wheels or steering instead of a gyro."""


class NoRanges(InputError):
    """Error for a log without the ranges or the start pose that localization by radio beacons needs."""


class ReplayedFix(NamedTuple):
    """Fix of the satellite receiver in a replayed log, and whether the localizer accepted it."""

    time: float
    """Time of the fix, in [s]."""
    position: tuple[float, float]
    """East and north, in [m]."""
    believed: bool
    why: str
    """Reason why the fix, or the filter's own estimate, was rejected; empty otherwise."""


class Replayed(NamedTuple):
    """Result of running a localizer on a log of recorded sensor readings.

    It has the estimated poses, and the log's reference poses and fixes.
    """

    times: FloatArray
    """(k,) in [s]."""
    poses: FloatArray
    """(k, 3) estimated poses: x, y in [m], heading in [rad]."""
    covariances: FloatArray
    """(k, 3, 3) covariances of the poses, of x, y in [m] and heading in [rad]."""
    known: BoolArray
    """(k,) whether the heading was known."""
    truth: FloatArray
    """(k, 3) reference poses of the log, x, y in [m] and heading in [rad]; NaN where they are unknown."""
    fixes: list[ReplayedFix]
    log_likelihood: float
    """Log-likelihood of the fixes; NaN for a localizer that does not compute it."""
    clouds: list[tuple[float, FloatArray]]
    """Times in [s], and particles (3, n) with x, y in [m] and heading in [rad]; empty without a particle
    filter.
    """
    ranges: tuple[int, int] = (0, 0)
    """Numbers of the ranges that a localizer by beacons received, and of those that it rejected."""

    @property
    def errors(self) -> FloatArray:
        """Errors (k, 3), estimate minus reference pose, of x, y in the world in [m] and heading in [rad]."""
        away = self.poses - self.truth
        away[:, 2] = (away[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
        return away


def localizer_for(
    log: DriveLog, noise: FieldNoise, kind: str = "gps_filter", alone: bool = False
) -> FieldLocalizer:
    """Create a localizer that starts at the log's start pose, or at its first fix.

    Args:
        log: the log to be replayed.
        noise: assumed noise of wheels, gyros and receiver.
        kind: `gps_filter`, `particle` or `beacons`.
        alone: True for a `gps_filter` with `noise` as its only hypothesis about the noise.
    """
    if log.antenna is not None:
        noise = noise._replace(antenna=log.antenna)
    if log.steered:
        noise = noise._replace(**STEERED_NOISE)
    x, y, heading = log.start
    position = 0.05
    if not math.isfinite(x) or not math.isfinite(y):
        known_rows = np.flatnonzero(np.isfinite(log.fixes).all(axis=1))
        x, y = log.fixes[known_rows[0]].tolist() if len(known_rows) else (0.0, 0.0)
        position = START_SIGMAS * noise.gps_white + math.hypot(*noise.antenna[:2])
        position += _way_before(log, known_rows)
    if not math.isfinite(heading):
        heading, noise = 0.0, noise._replace(start_heading=math.inf)
    start = Pose2(x, y, wrap(heading))
    if kind == "beacons":
        return _by_beacons(log, noise, start, position)
    if kind == "gps_filter":
        supposed = [noise_hypotheses(noise)[0]._replace(share=1.0, worse=0)] if alone else None
        return GpsFilter(start, noise, position, supposed=supposed, heading_sigma=HEADING_SIGMA)
    return ParticleFilter(start, particle_errors(noise, position), heading_sigma=PARTICLES_SIGMA)


def _way_before(log: DriveLog, known_rows: IntArray) -> float:
    """Return the way in [m] of the wheels to the first of the rows with a fix: from where the log begins, the
    vehicle was driven that far in an unknown direction.
    """
    until = int(known_rows[0]) + 1 if len(known_rows) else 1
    return float(np.abs(np.nan_to_num(log.wheels[1:until]).mean(axis=1)).sum())


def particle_errors(noise: FieldNoise, position: float) -> ParticleErrors:
    """Convert a vehicle's noise to the errors that the particle filter assumes.

    The filter does not estimate slowly varying errors. A gyro's bias and slipping wheels are therefore random
    walks that grow to the same size within `LASTS_S`, and slow errors of the fixes are white errors of the
    same size.

    Args:
        noise: noise of wheels, gyros and GPS.
        position: standard deviation of the start position per axis, in [m].
    """
    usual = ParticleErrors()
    bias = math.hypot(noise.gyro_bias, noise.gyro_warm_up)
    return ParticleErrors(
        forward=usual.forward,
        turn=usual.turn,
        start_position=position,
        start_heading=noise.start_heading,
        gps=max(noise.gps_white, 0.05),
        along=noise.slip * math.sqrt(2.0 * noise.slip_length),
        turn_time=math.hypot(noise.gyro_white, bias * math.sqrt(LASTS_S)),
        gps_slow=SLOW_COUNTS * noise.gps_drift,
    )


def _by_beacons(log: DriveLog, noise: FieldNoise, start: Pose2, position: float) -> BeaconFilter:
    """Create a localizer by beacons.

    Raises:
        NoRanges: the log has no ranges, or its start heading is unknown.
    """
    if log.beacons is None:
        raise NoRanges("the log has no ranges; needed: `beacons` in its header, and columns range_NAME")
    if math.isinf(noise.start_heading):
        raise NoRanges("ranges alone give no heading; needed: `start` with `heading_deg` in the log's header")
    return BeaconFilter(start, noise, log.beacons.errors, position)


def replay(
    log: DriveLog,
    localizer: FieldLocalizer,
    passed: Callable[[float], None] | None = None,
    period: float = 0.0,
    white: float | None = None,
) -> Replayed:
    """Run a localizer on the readings of a log, and return its estimates.

    Args:
        log: the log with all fixes.
        localizer: a new localizer.
        passed: called from time to time with the share of the log that is done, from 0 to 1.
        period: minimum time between fixes that the localizer receives, in [s]; closer fixes are skipped, but
            a closer fix that jumps is listed in the result.
        white: standard deviation of the uncorrelated (white) error of a fix, per axis, in [m], with which the
            detection of jumps starts; None: only the localizer detects jumps.
    """
    log = log.one_row_a_time()
    gate, latest = None if white is None else JumpGate(white), -math.inf
    ways = np.cumsum(np.nan_to_num(log.wheels).mean(axis=1))
    steps = np.diff(log.times, prepend=log.times[0])
    known_rows = np.isfinite(log.fixes.sum(axis=1))
    rows: list[int] = []
    poses, covariances, known, fixes = [], [], [], []
    due, clouds = log.times[0], list[tuple[float, FloatArray]]()
    kept = set(np.linspace(0, len(log.times) - 1, CLOUD_COUNT).astype(int).tolist())
    for row in range(len(log.times)):
        if row:  # the first row has no previous time
            localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], float(steps[row]))
        if log.beacons is not None and np.isfinite(log.beacons.ranges[row]).any():
            localizer.ranges(log.beacons.ranges[row])
        if known_rows[row]:
            sigma, time = float(log.sigmas[row]), float(log.times[row])
            x, y = log.fixes[row].tolist()
            heading = localizer.pose.theta if localizer.heading_known else None
            jump = ""
            if gate is not None:
                way, doubt = float(ways[row]), math.sqrt(float(localizer.covariance[2, 2]))
                jump = gate.refusal(time, log.fixes[row], localizer.odometry.pose, way, heading, sigma, doubt)
            if jump:
                fixes.append(ReplayedFix(time, (x, y), False, jump))
            elif time >= latest + MIN_PERIOD_SHARE * period:
                latest = time
                believed = localizer.fix(log.fixes[row], sigma if sigma > 0.0 else None)
                fixes.append(ReplayedFix(time, (x, y), believed, localizer.refusal))
        if row in kept and isinstance(localizer, ParticleFilter):
            clouds.append((float(log.times[row]), localizer.particles))
        if log.times[row] >= due or row == len(log.times) - 1:
            due = max(due + TRACK_PERIOD_S, log.times[row])
            rows.append(row)
            meanwhile = localizer.meanwhile
            poses.append(localizer.pose if meanwhile is None else meanwhile.mean)
            covariances.append(localizer.covariance if meanwhile is None else meanwhile.covariance)
            known.append(localizer.heading_known)
            if passed is not None:
                passed(row / len(log.times))
    return Replayed(
        log.times[rows],
        np.array(poses),
        np.array(covariances),
        np.array(known),
        log.reference[rows],
        fixes,
        localizer.log_likelihood,
        clouds,
        _ranges(log, localizer),
    )


def _ranges(log: DriveLog, localizer: FieldLocalizer) -> tuple[int, int]:
    if log.beacons is None or not isinstance(localizer, BeaconFilter):
        return 0, 0
    return int(np.isfinite(log.beacons.ranges).sum()), localizer.refused
