"""Detection of contradictory readings: frozen sensors, and wheels in other units or with reversed sign."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.evaluation.offline_localization.logs.places import repeated_rows
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .fix_noise import odometry_track

STILL_TIME_S = (8.0, 20.0)  # shortest and longest time at rest that is checked in one piece
MAX_STILL_M = 6.0  # motion of the fixes of a vehicle at rest within that time: slow errors
SPAN_PARTS = 5  # of that time; a moving vehicle advances from each to the next
MIN_PARTS = 3  # advancing steps between parts; a jump of the fixes makes one or two
MAX_STILL_SIGMAS = 6.0  # the same limit, in the receiver's stated accuracies
FROZEN_TIME_S = 3.0  # for which a gyro may repeat its reading
MIN_FROZEN = 20  # repeated readings
MIN_DRIVEN_M = 1.0  # during the repetitions: vibration changes a driving gyro's last digit
MAX_BACKWARD = 0.8  # share of the distance driven backwards
MIN_WAY_M = 10.0
SCALE_WINDOW_S = 60.0  # in which fixes are fitted to the odometry's track
MIN_SPREAD_M = 3.0  # root mean square distance of a window's fixes from their mean
MIN_FIXES = 8  # in a window
MIN_FIT = 0.9  # squared correlation of fixes and track
MAX_SCALE = 1.5  # between the distances by fixes and by wheels
UNIT_ERRORS = {
    1000.0: "km where m is needed, or m where mm is",
    1e-3: "mm where m is needed",
    1.0 / 3.6: "km/h where m/s is needed",
    0.44704: "mph where m/s is needed",
    0.3048: "feet where m is needed",
    math.radians(1.0): "degrees where m is needed",
}
"""Likely unit error, by the factor that corrects the readings."""
NEAR_UNIT = 0.1  # relative difference to a factor of `UNIT_ERRORS`
RADII_M = (0.02, 0.7)  # of wheels


def check_readings(log: DriveLog) -> tuple[DriveLog, list[str]]:
    """Remove repeated fixes from a log, and report sensors that are frozen, reversed or in wrong units.

    Args:
        log: log with all fixes and with its IMU in the base's axes.

    Returns:
        The log without the repeated fixes, and a message for each fault, with its time and what is allowed.
    """
    log, notes = _without_repeated(log)
    notes += [*_still_wheels(log), *_frozen_gyro(log), *_backwards(log), *_scaled(log)]
    return log, notes


def _without_repeated(log: DriveLog) -> tuple[DriveLog, list[str]]:
    """Remove fixes that repeat the previous one while the wheels turn."""
    again = repeated_rows(log.fixes[:, 0], log.fixes[:, 1])
    again &= _way_since_fix(log) > 0.05
    if not again.any():
        return log, []
    fixes = np.where(again[:, None], math.nan, log.fixes)
    words = (
        f"the receiver repeats a fix digit by digit {int(again.sum())} times while the wheels turn, first "
        f"after {_first_time(log, again):.1f} s; those are left out; allowed: each fix once"
    )
    return log._replace(fixes=fixes), [words]


def _way_since_fix(log: DriveLog) -> FloatArray:
    """Return the distance (n,) that the wheels have driven since the fix before each row, in [m]."""
    way = np.cumsum(np.abs(np.nan_to_num(log.wheels).mean(axis=1)))
    known = np.flatnonzero(np.isfinite(log.fixes).all(axis=1))
    found = np.zeros(len(way))
    found[known[1:]] = np.diff(way[known])
    return found


def _still_wheels(log: DriveLog) -> list[str]:
    """Return a note if the wheels are still while the fixes move."""
    still = np.asarray((np.nan_to_num(log.wheels) == 0.0).all(axis=1))
    stated = log.sigmas[np.isfinite(log.sigmas)]
    limit = max(MAX_STILL_M, MAX_STILL_SIGMAS * float(np.median(stated)) if len(stated) else 0.0)
    travelled = np.zeros(len(still))
    for begin, end in spans(still):
        for first, last in _pieces(log.times, begin, end):
            away = _travelled(log.fixes[first:last])
            if away > limit:
                travelled[first:last] = np.maximum(travelled[first:last], away)
    wrong = travelled > 0.0
    if not wrong.any():
        return []
    after = _first_time(log, wrong)
    return [
        f"the wheels stand still in {int(wrong.sum())} readings while the fixes travel "
        f"{travelled.max():.0f} m within {STILL_TIME_S[1]:.0f} s, first after {after:.1f} s: "
        f"the track is wrong there; allowed: {limit:.0f} m beside wheels that stand"
    ]


def _pieces(times: FloatArray, begin: int, end: int) -> list[tuple[int, int]]:
    """Return pieces of a time span that overlap by half, as first row and row after the last; empty if it is
    too short.

    Args:
        times: (n,) times of the rows, in [s].
        begin: first row of the span.
        end: row after the span's last.
    """
    least, most = STILL_TIME_S
    if times[end - 1] - times[begin] < least:
        return []
    starts = np.arange(times[begin], max(times[begin] + 1e-9, times[end - 1] - 0.5 * most), 0.5 * most)
    firsts = np.searchsorted(times, starts)
    lasts = np.minimum(np.searchsorted(times, starts + most), end)
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))


def _travelled(fixes: FloatArray) -> float:
    """Return the distance in [m] over which fixes (n, 2) advance steadily; 0 if they jump or stay."""
    known = fixes[np.isfinite(fixes).all(axis=1)]
    if len(known) < SPAN_PARTS:
        return 0.0
    middles = np.array([np.median(part, axis=0) for part in np.array_split(known, SPAN_PARTS)])
    chord = middles[-1] - middles[0]
    length = float(np.hypot(*chord))
    steps = np.diff(middles, axis=0) @ chord / max(length, 1e-9)
    return length if (steps > 0.5 * length / (SPAN_PARTS - 1)).sum() >= MIN_PARTS else 0.0


def _frozen_gyro(log: DriveLog) -> list[str]:
    """Return a note if the gyros repeat their readings while the wheels turn."""
    if log.steered:
        return []
    known = np.flatnonzero(np.isfinite(log.rates).all(axis=1))
    again = np.append(False, (np.diff(log.rates[known], axis=0) == 0.0).all(axis=1))
    way = np.cumsum(np.abs(np.nan_to_num(log.wheels).mean(axis=1)))
    found = []
    for begin, end in spans(again):
        first, last = known[max(0, begin - 1)], known[end - 1]
        lasts = float(log.times[last] - log.times[first])
        if lasts >= FROZEN_TIME_S and end - begin >= MIN_FROZEN and way[last] - way[first] > MIN_DRIVEN_M:
            found.append((int(first), end - begin, lasts))
    if not found:
        return []
    count, lasts = sum(count for _, count, _ in found), max(lasts for _, _, lasts in found)
    return [
        f"the gyros repeat their reading {count} times while the wheels turn, for {lasts:.1f} s at most, "
        f"first after {float(log.times[found[0][0]] - log.times[0]):.1f} s; allowed: {FROZEN_TIME_S:.0f} s; "
        "a recorder that repeats readings: `held: true` for that column"
    ]


def _backwards(log: DriveLog) -> list[str]:
    """Return a note if the vehicle drives backwards nearly all the time: the wheels' sign may be reversed."""
    steps = np.nan_to_num(log.wheels)
    way, backward = np.abs(steps).sum(axis=0) / 2.0, np.maximum(-steps, 0.0).sum(axis=0) / 2.0
    shares = backward / np.maximum(way, 1e-9)
    if way.sum() < MIN_WAY_M or shares.max() < MAX_BACKWARD:
        return []
    if shares.min() < 1.0 - MAX_BACKWARD:
        return [
            f"the left wheel turns backwards over {100.0 * shares[0]:.0f} % of its way and the right one "
            f"over {100.0 * shares[1]:.0f} %: one of them has the other sign; allowed: forward is positive, "
            "`factor: -1` turns a column's sign"
        ]
    return [
        f"the wheels turn backwards over {100.0 * shares.mean():.0f} % of {way.sum():.0f} m: the vehicle "
        "drives in reverse, or their sign is reversed and each heading is 180 degrees off; allowed: forward "
        "is positive, `factor: -1` turns a column's sign"
    ]


def _scaled(log: DriveLog) -> list[str]:
    """Return a note if fixes and wheels measure different distances: other units, slip, or a wrong clock."""
    scale = way_scale(log)
    if scale is None or 1.0 / MAX_SCALE < scale < MAX_SCALE:
        return []
    near = [words for unit, words in UNIT_ERRORS.items() if abs(scale / unit - 1.0) < NEAR_UNIT]
    if RADII_M[0] < scale < RADII_M[1]:
        near.append(f"rad/s of wheels with a radius of {1000.0 * scale:.0f} mm")
    guess = f": {' or '.join(near)}?" if near else ""
    return [
        f"the fixes travel {scale:.3g} times as far as the wheels say{guess}; allowed: 1/{MAX_SCALE} to "
        f"{MAX_SCALE} times; `unit` and `factor` of the column, or the clock, put it right"
    ]


def way_scale(log: DriveLog) -> float | None:
    """Return the ratio of the distance by fixes to the distance by the wheels, to detect wrong units.

    In each window of time, the ratio is the scale by which the wheels' track fits the fixes best, when it is
    also rotated and shifted (Umeyama, 1991, eq. 42). Mirror images are fitted as well, so that exchanged axes
    do not hide a wrong unit.

    Args:
        log: log with all fixes.

    Returns:
        Median of the ratio over all windows; None if no window has `MIN_FIXES` fixes that are spread by
        `MIN_SPREAD_M` and fit the wheels' track.
    """
    times, ways, fixes = odometry_track(log)
    a, b = ways @ np.array([1.0, 1.0j]), fixes @ np.array([1.0, 1.0j])
    found = []
    for begin in np.arange(times[0], times[-1], 0.5 * SCALE_WINDOW_S) if len(times) else ():
        inside = (times >= begin) & (times < begin + SCALE_WINDOW_S)
        if inside.sum() >= MIN_FIXES:
            found += _window_scale(a[inside] - a[inside].mean(), b[inside] - b[inside].mean())
    return float(np.median(found)) if found else None


def _window_scale(ways: NDArray[np.complex128], fixes: NDArray[np.complex128]) -> list[float]:
    spread, whole = float((np.abs(fixes) ** 2).sum()), float((np.abs(ways) ** 2).sum())
    if spread < len(fixes) * MIN_SPREAD_M**2 or whole <= 0.0:
        return []
    common = max(float(abs(np.vdot(ways, fixes))), float(abs(np.vdot(ways.conj(), fixes))))
    return [common / whole] if common**2 > MIN_FIT * spread * whole else []


def spans(rows: BoolArray) -> list[tuple[int, int]]:
    """Return begin and end of each uninterrupted sequence of True in a mask (n,), as row indices.

    The end is the row after the last True.
    """
    ends = np.diff(np.concatenate([[False], rows, [False]]).astype(int))
    return list(zip(np.flatnonzero(ends > 0).tolist(), np.flatnonzero(ends < 0).tolist(), strict=True))


def _first_time(log: DriveLog, rows: BoolArray) -> float:
    return float(log.times[int(np.argmax(rows))] - log.times[0])
