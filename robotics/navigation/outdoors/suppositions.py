"""What a filter supposes of wheels, gyros and GPS besides what it is told of them."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.robotics.navigation.outdoors.field_noise import FieldNoise

LATE = 0.3  # [s] that a receiver's fixes may come too late, whatever is told
SKIES = ((0.0, math.inf, 0.55), (0.25, 600.0, 0.25), (0.75, 600.0, 0.15), (4.0, 100.0, 0.05))
"""Slow error of the fixes, in sigmas of one; over how many seconds it changes; share of worlds."""
GROUNDS = (0.6, 0.3, 0.1)  # shares of worlds: as told, more slip than told, a start heading further off


class Supposition(NamedTuple):
    """One way in which a world may be other than told."""

    noise: FieldNoise
    share: float
    """Of worlds that are so, before anything was seen."""
    worse: int
    """Which of the suppositions has the same ground under the next worse sky; itself under the worst."""

    def may_become(self, other: Supposition) -> bool:
        """Whether a world that is so far like this may turn out to be like the other one: a worse one."""
        here, there = _badness(self.noise), _badness(other.noise)
        return here != there and all(a <= b for a, b in zip(here, there, strict=True))


def _badness(noise: FieldNoise) -> tuple[float, float, float]:
    return noise.gps_drift, noise.slip, noise.start_heading


def suppositions(told: FieldNoise) -> list[Supposition]:
    """Each sky over each ground, as told first; what is worse comes later."""
    told = told._replace(gps_delay=max(told.gps_delay, LATE))
    found: list[Supposition] = []
    for sigma, time, share in SKIES:
        sky = told if sigma == 0.0 else _drifting(told, sigma, time)
        last = len(SKIES) * len(GROUNDS) - len(GROUNDS)
        for noise, rough in zip((sky, _slipping(sky), _turned(sky)), GROUNDS, strict=True):
            here = len(found)
            found.append(Supposition(noise, share * rough, here if here >= last else here + len(GROUNDS)))
    return found


def _drifting(told: FieldNoise, sigma: float, time: float) -> FieldNoise:
    drift = math.hypot(told.gps_drift, sigma * told.gps_white)
    return told._replace(gps_drift=drift, gps_drift_time=time)


def _slipping(told: FieldNoise) -> FieldNoise:
    return told._replace(
        scale=5.0 * told.scale,
        slip=3.0 * told.slip,
        turn_slip=2.5 * told.turn_slip,
        side_slip=3.0 * told.side_slip,
    )


def _turned(told: FieldNoise) -> FieldNoise:
    return told._replace(start_heading=max(math.radians(6.0), told.start_heading))
