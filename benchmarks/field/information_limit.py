"""Best accuracy of any filter with given sensors: the posterior Cramér-Rao bound.

For the nearly linear model of `FieldModel` it is the covariance of a Kalman filter that is linearised
about the truth and knows every sigma (Tichavský, Muravchik and Nehorai, 1998).
"""

from __future__ import annotations

import math

import numpy as np

from benchmarks.field.field_drive import PERIOD_S, FieldDrive
from handcart.robotics.navigation.outdoors.field_model import (
    BIAS,
    GPS_X,
    GPS_Y,
    HEADING,
    STATE_SIZE,
    WARM_UP,
    FieldModel,
    carried,
    corrected,
)
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.numerics.arrays import FloatArray, IntArray

PERIODS_PER_STEP = 4  # periods put together, as a filter does


def information_limit(
    drive: FieldDrive, fix_rows: IntArray, noise: FieldNoise, start_position: float = 0.05
) -> FloatArray:
    """Covariances (k, 3, 3) of x, y in [m], heading in [rad] at a drive's placings: none can be below them.

    Args:
        drive: the truth.
        fix_rows: (m,) rows after which a fix comes in.
        noise: the true sigmas.
        start_position: sigma of the position at the start, in [m].
    """
    model = FieldModel(noise, tilt=0.0)
    mean, spread = model.start(drive.poses[0], start_position)
    fixes, wanted = (
        set((fix_rows // PERIODS_PER_STEP).tolist()),
        (drive.placings // PERIODS_PER_STEP).tolist(),
    )
    bias = np.zeros((1, STATE_SIZE))
    bias[0, [BIAS, WARM_UP]] = 1.0
    bounds, rested = {}, True
    for block in range(max(wanted) + 1):
        rows = slice(block * PERIODS_PER_STEP, (block + 1) * PERIODS_PER_STEP)
        advance = _advance(drive, rows)
        resting = advance.forward == 0.0
        _, transition, added = model.step(mean, advance, rested and not resting)
        spread, rested = carried(spread, transition, added), resting
        mean[:3] = drive.poses[rows][-1]
        if resting:
            _, spread = corrected(mean, spread, bias, np.zeros(1), noise.gyro_white**2 / advance.time)
        if block in fixes:
            seen = _fix_rows(mean, noise)
            _, spread = corrected(mean, spread, seen, np.zeros(2), noise.gps_white**2)
        bounds[block] = spread[:3, :3].copy()
    return np.array([bounds[block] for block in wanted])


def _advance(drive: FieldDrive, rows: slice) -> Advance:
    """Return the readings of sensors without errors."""
    way, bend = drive.driven[rows].T
    time = PERIOD_S * len(way)
    level = float((way * np.cos(drive.tilts[rows, 1])).sum())
    return Advance(level, float((way * bend).sum()), 0.0, time, time if level == 0.0 else 0.0, 0.0)


def _fix_rows(mean: FloatArray, noise: FieldNoise) -> FloatArray:
    """Return (2, 13) how a fix depends on the states."""
    x, y, _ = noise.antenna
    cos, sin = math.cos(mean[HEADING]), math.sin(mean[HEADING])
    rows = np.zeros((2, STATE_SIZE))
    rows[[0, 1], [0, 1]] = rows[[0, 1], [GPS_X, GPS_Y]] = 1.0
    rows[:, HEADING] = -(sin * x + cos * y), cos * x - sin * y
    return rows
