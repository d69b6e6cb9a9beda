"""Noise hypotheses of a filter besides the given noise of wheels, gyros and GNSS."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.robotics.navigation.outdoors.field_noise import FieldNoise

MAX_FIX_DELAY_S = 0.3  # [s] that a receiver's fixes may come later than stated
GNSS_CONDITIONS = ((0.0, math.inf, 0.55), (0.25, 600.0, 0.25), (0.75, 600.0, 0.15))
"""Slow error of the fixes in sigmas of one fix, time in [s] over which it changes, and prior probability."""
LEAP_CONDITION = (3.0, 600.0, 0.05)  # the same of an error that leaps besides
# [s] on average: with a shorter one, reflections of some seconds count as leaps
MIN_LEAP_INTERVAL_S = 1000.0
GROUND_SHARES = (
    0.6,
    0.3,
    0.1,
)  # shares of worlds: as given, more slip than given, a start heading further off


class NoiseHypothesis(NamedTuple):
    """Hypothesis on the noise of satellite fixes and wheels, with a noise model that may be worse than the
    one that the robot's file gives.
    """

    noise: FieldNoise
    share: float
    """Prior probability of the hypothesis."""
    worse: int
    """Index of the hypothesis with the same ground and the next worse GNSS condition; its own for the
    worst.
    """

    def may_become(self, other: NoiseHypothesis) -> bool:
        """Return True if readings that fit this hypothesis so far may later fit the other hypothesis.

        That is so if the other noise model is different, and in no respect has smaller errors.
        """
        here, there = _badness(self.noise), _badness(other.noise)
        return here != there and all(a <= b for a, b in zip(here, there, strict=True))


def _badness(noise: FieldNoise) -> tuple[float, float, float]:
    return noise.gps_drift, noise.slip, noise.start_heading


def noise_hypotheses(given: FieldNoise) -> list[NoiseHypothesis]:
    """Return the hypotheses on the noise: each GNSS condition combined with each condition of the ground.

    The given noise model comes first, worse conditions later. In all of them the delay of fixes has a
    standard deviation of at least `MAX_FIX_DELAY_S`.
    """
    given = given._replace(gps_delay=max(given.gps_delay, MAX_FIX_DELAY_S))
    found: list[NoiseHypothesis] = []
    skies = [(_drifting(given, sigma, time), share) for sigma, time, share in GNSS_CONDITIONS[1:]]
    skies = [
        (given, GNSS_CONDITIONS[0][2]),
        *skies,
        (_leaping(given, *LEAP_CONDITION[:2]), LEAP_CONDITION[2]),
    ]
    last = (len(skies) - 1) * len(GROUND_SHARES)
    for sky, share in skies:
        for noise, rough in zip((sky, _slipping(sky), _turned(sky)), GROUND_SHARES, strict=True):
            here = len(found)
            found.append(
                NoiseHypothesis(noise, share * rough, here if here >= last else here + len(GROUND_SHARES))
            )
    return found


def _drifting(given: FieldNoise, sigma: float, time: float) -> FieldNoise:
    drift = math.hypot(given.gps_drift, sigma * given.gps_white)
    return given._replace(gps_drift=drift, gps_drift_time=time)


def _leaping(given: FieldNoise, sigma: float, time: float) -> FieldNoise:
    drifting = _drifting(given, sigma, time)
    return drifting._replace(jump=drifting.gps_drift, jump_every=MIN_LEAP_INTERVAL_S)


def _slipping(given: FieldNoise) -> FieldNoise:
    return given._replace(
        scale=5.0 * given.scale,
        slip=5.0 * given.slip,
        turn_slip=5.0 * given.turn_slip,
        side_slip=3.0 * given.side_slip,
    )


def _turned(given: FieldNoise) -> FieldNoise:
    return given._replace(start_heading=max(math.radians(6.0), given.start_heading))
