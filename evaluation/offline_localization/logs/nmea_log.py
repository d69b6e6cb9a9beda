"""Import of fixes from a receiver's NMEA log into a log of wheels and gyros."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np

from handcart.backends.can.sensors.nmea_sentence import (
    NO_SATELLITE_FIXES,
    Accuracy,
    Position,
    read_sentence,
)
from handcart.files.errors import FileError, Finding
from handcart.files.printable import counted
from handcart.files.regular_file import read_regular_file
from handcart.robotics.numerics.arrays import FloatArray

from .csv_log import MAX_BYTES, first_place, plane
from .drive_log import DriveLog
from .places import checked_places

DAY_S = 86_400.0
MIN_TIME_OF_DAY_S = 1.0  # a log that begins earlier counts its times from its own begin
ASSUMED_UTC = (
    "the log's times, from {begun:g} s on, are taken as seconds of the day in UTC, because fixes then fall "
    "into it; if they count from something else, subtract the first from all"
)
UNKNOWN_CLOCK = "the log's clock is not UTC; the first fix is assumed to coincide with the first row"


def with_nmea(log: DriveLog, path: Path) -> DriveLog:
    """Return a copy of a log whose fixes are replaced by those in a file of NMEA 0183 sentences (GGA, GST).

    The receiver's clock is UTC. If the log's times are seconds since 1970, or of the day so that its fixes
    fall into the log, they are taken as UTC too, the latter with a note; otherwise the first fix is assumed
    to coincide with the first row, and a note says so. Damaged sentences are skipped.

    Raises:
        FileError: the file cannot be read, or contains no fix, or none in the time of the log.
    """
    positions, accuracies, others = [], {}, Counter[int]()
    for line in read_regular_file(path, MAX_BYTES).splitlines():
        try:
            sentence = read_sentence(line.strip())
        except (ValueError, UnicodeDecodeError):
            continue
        if isinstance(sentence, Accuracy):
            accuracies[round(sentence.utc, 1)] = sentence.sigma
        elif isinstance(sentence, Position) and sentence.is_fix:
            positions.append(sentence)
        elif isinstance(sentence, Position):
            others[sentence.quality] += 1
    skipped = _skipped(others)
    if not positions:
        wrong = "no fix in it; needed: GGA sentences of NMEA 0183 with a place and sound checksums"
        raise FileError([Finding(str(path), 1, 1, "; ".join([wrong, *skipped]))])
    times = np.unwrap([position.utc for position in positions], period=DAY_S)
    first, is_utc = _first(log, times)
    times = times - times[0] + first
    if not ((log.times[0] <= times) & (times <= log.times[-1])).any():
        raise FileError([Finding(str(path), 1, 1, _outside(log, times))])
    if log.times[0] < DAY_S:
        skipped.insert(0, ASSUMED_UTC.format(begun=log.times[0]) if is_utc else UNKNOWN_CLOCK)
    lats, lons, notes = checked_places(
        np.array([position.lat for position in positions]),
        np.array([position.lon for position in positions]),
        times,
    )
    places = plane(lats, lons, log.origin or first_place(lats, lons))
    fixes, sigmas = np.full_like(log.fixes, math.nan), np.full_like(log.sigmas, math.nan)
    for time, place, position in zip(times, places, positions, strict=True):
        row = int(np.searchsorted(log.times, time))
        if row < len(log.times) and time >= log.times[0]:
            fixes[row], sigmas[row] = place, accuracies.get(round(position.utc, 1), math.nan)
    return log._replace(fixes=fixes, sigmas=sigmas, notes=(*log.notes, *notes, *skipped))


def _skipped(others: Counter[int]) -> list[str]:
    """Return a note for each quality whose positions are not satellite fixes."""
    return [
        f"skipped {counted(count, 'place')} of quality {quality}: "
        + NO_SATELLITE_FIXES.get(quality, "unknown in NMEA 0183")
        for quality, count in sorted(others.items())
        if quality != 0
    ]


def _first(log: DriveLog, utc: FloatArray) -> tuple[float, bool]:
    """Return the time of the first fix on the log's clock, in [s], and whether that clock is UTC.

    Args:
        log: log of the drive.
        utc: (n,) times of the fixes on the receiver's clock, in [s], increasing, also past midnight.
    """
    begun, ended = float(log.times[0]), float(log.times[-1])
    if begun < MIN_TIME_OF_DAY_S:
        return begun, False
    nearest = begun + (float(utc[0]) - begun + DAY_S / 2) % DAY_S - DAY_S / 2
    for first in (nearest, nearest - DAY_S):  # a receiver may be on for half a day before the log begins
        if first <= ended and first + utc[-1] - utc[0] >= begun:
            return first, True
    return (begun, False) if begun < DAY_S else (nearest, True)


def _outside(log: DriveLog, times: FloatArray) -> str:
    """Return the message about a file without fixes within the log."""
    early, late = log.times[0] - times[-1], times[0] - log.times[-1]
    lies = (
        f"end {early:.1f} s before its first row" if early > 0.0 else f"begin {late:.1f} s after its last row"
    )
    return f"no fix within the log: the fixes {lies}; needed: the receiver's log of the same drive"
