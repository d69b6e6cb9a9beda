"""Detection of latitudes and longitudes that no receiver measured."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

FAR_DEG = 1.0  # from the median of all fixes: some 100 km
MIN_HELD_FIXES = 5  # equal fixes in a row that count as repetitions


def checked_places(
    latitudes: FloatArray, longitudes: FloatArray, times: FloatArray
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Remove implausible fixes, and report their number and their first time.

    These are beyond the range of degrees, at (0, 0), about 100 km from most others, or mere repetitions.

    Args:
        latitudes: (n,) in [deg]; NaN without a fix.
        longitudes: (n,) in [deg].
        times: (n,) in [s], named in the notes.

    Returns:
        Latitudes (n,) and longitudes (n,) in [deg], with NaN in place of removed fixes, and notes.
    """
    known = np.isfinite(latitudes) & np.isfinite(longitudes)
    notes = list[str]()
    outside = known & ((np.abs(latitudes) > 90.0) | (np.abs(longitudes) > 360.0))
    if known.any() and outside.sum() > 0.5 * known.sum() and (np.abs(longitudes[known]) <= 90.0).mean() > 0.5:
        notes.append("latitudes beyond 90 degrees: latitude and longitude are exchanged")
    zero = known & (latitudes == 0.0) & (longitudes == 0.0)
    inside = known & ~outside & ~zero
    away = np.zeros(len(known), dtype=bool)
    if inside.any():
        middle = np.median(latitudes[inside])
        turned = np.abs((longitudes - np.median(longitudes[inside]) + 180.0) % 360.0 - 180.0)
        near_pole = abs(middle) > 85.0
        away = inside & ((np.abs(latitudes - middle) > FAR_DEG) | ((turned > 5.0 * FAR_DEG) & ~near_pole))
    for wrong, what in (
        (outside, "lie beyond the range of degrees"),
        (zero, "are at (0, 0), which receivers report without a fix"),
        (away, "lie more than 100 km from the others"),
    ):
        if wrong.any():
            notes.append(_left_out(what, wrong, times))
    held = repeated_rows(latitudes, longitudes)
    if held.any():
        notes.append(_left_out("only repeat the one before", held, times))
    left = outside | zero | away | held
    return np.where(left, np.nan, latitudes), np.where(left, np.nan, longitudes), notes


def _left_out(what: str, wrong: BoolArray, times: FloatArray) -> str:
    after = float(times[int(np.argmax(wrong))] - times[0])
    return f"{int(wrong.sum())} fixes {what}, first after {after:.1f} s; they are left out"


def repeated_rows(latitudes: FloatArray, longitudes: FloatArray) -> BoolArray:
    """Return a mask (n,) that is True where a satellite fix repeats the previous one exactly.

    Only series of at least `MIN_HELD_FIXES` equal fixes count.

    Args:
        latitudes: (n,) latitudes in [deg], or any first coordinate; NaN without a fix.
        longitudes: (n,) longitudes in [deg], or any second coordinate.
    """
    rows = np.flatnonzero(np.isfinite(latitudes) & np.isfinite(longitudes))
    found = np.zeros(len(latitudes), dtype=bool)
    if len(rows) < MIN_HELD_FIXES:
        return found
    again = (np.diff(latitudes[rows]) == 0.0) & (np.diff(longitudes[rows]) == 0.0)
    ends = np.diff(np.concatenate([[False], again, [False]]).astype(int))
    for begin, end in zip(np.flatnonzero(ends > 0), np.flatnonzero(ends < 0), strict=True):
        if end - begin >= MIN_HELD_FIXES - 1:
            found[rows[begin + 1 : end + 1]] = True
    return found
