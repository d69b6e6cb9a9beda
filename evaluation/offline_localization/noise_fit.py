"""Maximum-likelihood fit of the noise to a recorded log."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.navigation.outdoors.field_noise import ANY_VEHICLE, FieldNoise

from .replay import localizer_for, replay

KNOB_FACTORS = (0.25, 0.5, 0.71, 1.41, 2.0, 4.0)
DRIFT_SHARES = (0.0, 0.25, 0.5, 1.0, 2.0)  # relative to a fix's white error
ANY_VEHICLE_TEXT = "as of any vehicle"
LENGTH_FACTORS = (0.25, 4.0)
MAX_ROUNDS = 4  # through all knobs
MIN_LIKELIHOOD_GAIN = 3.0  # of the log-likelihood: a smaller gain is chance


class Knob(NamedTuple):
    """Group of noise parameters that the fit scales together by one factor."""

    words: str
    turned: Callable[[FieldNoise, float], FieldNoise]
    factors: tuple[float, ...] = KNOB_FACTORS


class Fitted(NamedTuple):
    """Noise of a vehicle that explains a log's GNSS fixes best, with their log-likelihood before and after
    the fit.
    """

    noise: FieldNoise
    before: float
    """Log-likelihood of the fixes with the given noise."""
    after: float
    changed: dict[str, float]
    """Factor of each changed knob, relative to the given noise or to that of any vehicle."""


def _wheels(noise: FieldNoise, factor: float) -> FieldNoise:
    return noise._replace(
        scale=factor * noise.scale,
        slip=factor * noise.slip,
        turn_slip=factor * noise.turn_slip,
        side_slip=factor * noise.side_slip,
    )


def _gyro(noise: FieldNoise, factor: float) -> FieldNoise:
    return noise._replace(
        gyro_white=factor * noise.gyro_white,
        gyro_walk=factor * noise.gyro_walk,
        gyro_bias=factor * noise.gyro_bias,
        gyro_scale=factor * noise.gyro_scale,
    )


def _white(noise: FieldNoise, factor: float) -> FieldNoise:
    return noise._replace(gps_white=factor * noise.gps_white)


def _drift(noise: FieldNoise, share: float) -> FieldNoise:
    return noise._replace(gps_drift=share * noise.gps_white)


def _lasting(noise: FieldNoise, factor: float) -> FieldNoise:
    return noise._replace(slip_length=factor * noise.slip_length)


NOISE_KNOBS = (
    Knob("fixes, white", _white),
    Knob("fixes, drift, in white ones", _drift, DRIFT_SHARES),
    Knob("wheels", _wheels),
    Knob("way over which wheels slip alike", _lasting, LENGTH_FACTORS),
    Knob("gyros", _gyro),
)


def fit_noise(log: DriveLog, given: FieldNoise, passed: Callable[[float], None] | None = None) -> Fitted:
    """Fit the noise of a vehicle to a log by the likelihood of its fixes.

    One group of noise parameters after the other is scaled while the likelihood increases (coordinate
    ascent).

    Args:
        log: a drive with fixes, preferably kilometres long.
        given: initial noise.
        passed: called from time to time with the share of the fit that is done, from 0 to 1.
    """
    noise, best = given, _likelihood(log, given)
    before, changed = best, dict[str, float]()
    likely = _likelihood(log, any_vehicle := _of_any_vehicle(given))
    if likely > best + MIN_LIKELIHOOD_GAIN:  # too far away for coordinate ascent
        noise, best, changed = any_vehicle, likely, {ANY_VEHICLE_TEXT: 1.0}
    work = MAX_ROUNDS * sum(len(knob.factors) for knob in NOISE_KNOBS)
    done = 0
    for _ in range(MAX_ROUNDS):
        begun = best
        for knob in NOISE_KNOBS:
            tried = []
            for factor in knob.factors:
                tried.append((_likelihood(log, knob.turned(noise, factor)), factor))
                done += 1
                if passed is not None:
                    passed(done / work)
            likely, factor = max(tried)
            if likely > best + MIN_LIKELIHOOD_GAIN:
                noise, best = knob.turned(noise, factor), likely
                turned = factor if knob.turned is _drift else changed.get(knob.words, 1.0) * factor
                changed[knob.words] = turned
        if best == begun:
            break
    return Fitted(noise, before, best, changed)


def _of_any_vehicle(given: FieldNoise) -> FieldNoise:
    return ANY_VEHICLE._replace(
        antenna=given.antenna, gps_period=given.gps_period, start_heading=given.start_heading
    )


def _likelihood(log: DriveLog, noise: FieldNoise) -> float:
    """Return the log-likelihood of all fixes for a filter with this noise as its only hypothesis."""
    return replay(log, localizer_for(log, noise, alone=True)).log_likelihood


def in_yaml(noise: FieldNoise) -> str:
    """Return the noise in the YAML format of a robot's file."""
    deg = math.degrees
    return "\n".join(
        [
            "ground:",
            f"  scale_percent: {100 * noise.scale:.3g}",
            f"  slip_percent: {100 * noise.slip:.3g}",
            f"  slip_length_m: {noise.slip_length:.3g}",
            f"  turn_slip_percent: {100 * noise.turn_slip:.3g}",
            f"  side_slip_deg: {deg(noise.side_slip):.3g}",
            "imu:",
            f"  angle_random_walk_deg_rt_s: {deg(noise.gyro_white):.3g}",
            f"  rate_random_walk_deg_s_rt_s: {deg(noise.gyro_walk):.3g}",
            f"  gyro_bias_deg_s: {deg(noise.gyro_bias):.3g}",
            f"  gyro_scale_percent: {100 * noise.gyro_scale:.3g}",
            "gps:",
            f"  white_m: {noise.gps_white:.3g}",
            f"  drift_m: {noise.gps_drift:.3g}",
            f"  drift_time_s: {noise.gps_drift_time:.3g}",
        ]
    )
