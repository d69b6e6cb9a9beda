"""Plant sensor faults in logs: `python -m benchmarks.damage.sensor_faults [--logs N] [--seed N]`

Logs of a lawn mower, a truck and a skid-steer robot (`benchmarks.field.foreign_logs`). In the second half
of each the wheels stop, the gyros freeze or the receiver repeats its fix; or over the whole log the wheels
have another sign or unit, or the axes of the fixes are exchanged. Prints for each fault the number of logs
in which `handcart localize` reports it. Without a fault, and for a parked vehicle, it has to report
nothing.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.progress import track

from benchmarks.field.foreign_logs import ALL_VEHICLES, GRAVITY_M_S2, record_foreign
from handcart.evaluation.offline_localization.checks.mirror import MIRROR_TEXT as MIRRORED
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.evaluation.offline_localization.preparation import prepare
from handcart.robotics.navigation.outdoors.field_noise import ANY_VEHICLE
from handcart.robotics.numerics.arrays import FloatArray

LATITUDE_RAD = math.radians(48.0)
REPORTED_FAULTS = (
    "wheels stand still",
    "gyros repeat",
    "repeats a fix",
    "turn backwards",
    "turns backwards",
    "times as far",
    MIRRORED,
)
"""Words by which a note on a sensor fault is known."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--logs", type=int, default=10, help="of each vehicle (default 10)")
    parser.add_argument("--seed", type=int, default=0, help="of the first one (default 0)")
    parser.add_argument("--seconds", type=float, default=300.0, help="length of a log (default 300)")
    chosen = parser.parse_args()
    met = True
    for name, (fault, words) in SENSOR_FAULTS.items():
        right = 0
        for vehicle in ALL_VEHICLES:
            for seed in track(range(chosen.seed, chosen.seed + chosen.logs), f"{name}, {vehicle}"):
                notes = reports(fault(record_foreign(vehicle, seed, chosen.seconds).log))
                right += any(words in note for note in notes) if words else not notes
        count = chosen.logs * len(ALL_VEHICLES)
        print(f"{name}: {'reported in' if words else 'not a word in'} {right} of {count} logs", flush=True)
        met &= right == count
    sys.exit(0 if met else 1)


def reports(log: DriveLog) -> list[str]:
    """Return the notes on sensor faults with which a log is played."""
    notes = prepare(Path("log"), log, ANY_VEHICLE, False, "auto").log.notes
    return [note for note in notes if any(words in note for words in REPORTED_FAULTS)]


def without_fault(log: DriveLog) -> DriveLog:
    """Return the log as it is."""
    return log


def parked(log: DriveLog) -> DriveLog:
    """Return a log whose vehicle is at rest from the middle on, with the errors of its receiver."""
    half = _half(log)
    wheels, turns = _zero_from(log.wheels, half), _zero_from(log.odometry_turns, half)
    rates, felt = log.rates.copy(), log.accelerations.copy()
    drift = 1e-3 * np.random.default_rng(0).standard_normal(rates[half:].shape)
    rates[half:] = drift
    felt[half:] = (
        GRAVITY_M_S2 * np.median(felt[:half], axis=0) / np.linalg.norm(np.median(felt[:half], axis=0))
    )
    fixes = log.fixes.copy()
    fixes[half:] += log.reference[half, :2] - log.reference[half:, :2]
    return log._replace(wheels=wheels, rates=rates, accelerations=felt, fixes=fixes, odometry_turns=turns)


def wheels_stand(log: DriveLog) -> DriveLog:
    """Let the wheels' encoders report no travel from the middle on."""
    half = _half(log)
    return log._replace(
        wheels=_zero_from(log.wheels, half), odometry_turns=_zero_from(log.odometry_turns, half)
    )


def gyros_freeze(log: DriveLog) -> DriveLog:
    """Repeat the reading of the gyros from the middle on."""
    rates = log.rates.copy()
    rates[_half(log) :] = rates[_half(log)]
    return log._replace(rates=rates)


def receiver_freezes(log: DriveLog) -> DriveLog:
    """Repeat a fix with new stamps from the middle on."""
    fixes = log.fixes.copy()
    rows = np.flatnonzero(np.isfinite(fixes[:, 0]))
    rows = rows[rows >= _half(log)]
    fixes[rows] = fixes[rows[0]]
    return log._replace(fixes=fixes)


def exchanged(log: DriveLog) -> DriveLog:
    """Exchange latitude and longitude, at a latitude of 48 degrees."""
    east, north = log.fixes.T
    return log._replace(fixes=np.stack([north / math.cos(LATITUDE_RAD), east], axis=1))


def wheels_times(factor: float) -> Callable[[DriveLog], DriveLog]:
    """Return a fault that multiplies the travel of both wheels."""
    return lambda log: log._replace(wheels=factor * log.wheels)


def left_wheel_reversed(log: DriveLog) -> DriveLog:
    """Reverse the sign of the left wheel alone."""
    return log._replace(wheels=log.wheels * np.array([-1.0, 1.0]))


def _half(log: DriveLog) -> int:
    return len(log.times) // 2


def _zero_from(values: FloatArray | None, row: int) -> FloatArray:
    assert values is not None
    found = values.copy()
    found[row:] = 0.0
    return found


SENSOR_FAULTS: dict[str, tuple[Callable[[DriveLog], DriveLog], str]] = {
    "no fault": (without_fault, ""),
    "parked": (parked, ""),
    "wheels stand": (wheels_stand, "wheels stand still"),
    "gyros freeze": (gyros_freeze, "gyros repeat"),
    "receiver freezes": (receiver_freezes, "repeats a fix"),
    "wheels reversed": (wheels_times(-1.0), "turn backwards"),
    "left wheel reversed": (left_wheel_reversed, "turns backwards"),
    "mm as m": (wheels_times(1000.0), "times as far"),
    "m as mm": (wheels_times(1e-3), "times as far"),
    "km/h as m/s": (wheels_times(3.6), "times as far"),
    "rad/s as m/s": (wheels_times(1.0 / 0.15), "times as far"),
    "latitude and longitude exchanged": (exchanged, MIRRORED),
}
"""Each fault, and the words with which it has to be reported; none: nothing may be reported."""


if __name__ == "__main__":
    main()
