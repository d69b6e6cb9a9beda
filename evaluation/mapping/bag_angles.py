"""Angles and ranges of `sensor_msgs/LaserScan` messages, each scan by its own angles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MAX_TURNS = 1.1
"""Angle between first and last beam beyond which a scan is not one of a lidar, in turns."""
LOOSE_STEPS = 2.5
"""Distance between the last beam and `angle_max`, in beams, from which a note reports it.

Drivers differ by one beam at each end: `angle_max` is the last beam, or the first one of the next turn.
"""


def has_usable_angles(scan: Any) -> bool:
    """Return whether a scan has at least two beams, at different angles within about one turn."""
    first, step, count = float(scan.angle_min), float(scan.angle_increment), len(scan.ranges)
    spread = abs(step) * (count - 1)
    return math.isfinite(first) and 0.0 < spread <= MAX_TURNS * math.tau


def angles_in_words(scan: Any) -> str:
    """Return number, first angle and increment of a scan's beams as text."""
    step = f"{float(scan.angle_increment):g}"
    return f"{len(scan.ranges)} beams from {float(scan.angle_min):g} rad, angle_increment {step} rad"


def angle_notes(scans: Sequence[Any]) -> Iterator[str]:
    """Yield notes about a driver whose scans have different lengths, or whose angles contradict each other.

    Args:
        scans: scans with usable angles.
    """
    counts = [len(scan.ranges) for scan in scans]
    if min(counts) < max(counts):
        yield f"scans of {min(counts)} to {max(counts)} beams; each is read by its own angles"
    backward, loose = 0, list[float]()
    for scan in scans:
        step = float(scan.angle_increment)
        stated = float(scan.angle_max) - float(scan.angle_min)
        if not math.isfinite(stated) or abs(stated) <= 2.0 * abs(step):
            continue  # unset, or the angles of a full turn in a range that wraps
        if stated * step < 0.0:
            backward += 1
        else:
            loose.append(abs(stated / step) - (len(scan.ranges) - 1))
    if backward:
        yield (
            f"{backward} scans have an angle_increment that leads away from angle_max; it is taken as it is: "
            "the map is mirrored if only its sign is wrong"
        )
    off = float(np.median(loose)) if loose else 0.0
    if abs(off) > LOOSE_STEPS:
        yield (
            f"the last beam is {abs(off):.0f} beams {'short of' if off > 0.0 else 'past'} angle_max; "
            "angle_increment is taken as it is: walls are bent if it is wrong"
        )


def scan_arrays(scans: Sequence[Any], is_flipped: bool) -> tuple[FloatArray, FloatArray]:
    """Return angles and ranges of scans, which may have different numbers of beams.

    Args:
        scans: scans with usable angles.
        is_flipped: True for a lidar that is mounted upside down; its scans are reversed.

    Returns:
        Angles in the sensor frame in [rad], (b,) if all scans have the same ones, otherwise (n, b), and
            ranges (n, b) in [m] by REP 117. Shorter scans are filled with NaN ranges.
    """
    count = max(len(scan.ranges) for scan in scans)
    places = np.arange(count, dtype=np.float64)
    angles = np.array([float(scan.angle_min) + float(scan.angle_increment) * places for scan in scans])
    ranges = np.array([_ranges(scan, count) for scan in scans])
    if is_flipped:
        angles, ranges = -angles[:, ::-1], ranges[:, ::-1]
    return (angles[0] if (angles == angles[0]).all() else angles), ranges


def _ranges(scan: Any, count: int) -> FloatArray:
    """Return the ranges (count,) of a scan by REP 117; a beam that is missing at the end is unknown."""
    raw = np.asarray(scan.ranges, dtype=np.float64)
    ranges = np.full(count, math.nan)
    ranges[: len(raw)] = raw
    with np.errstate(invalid="ignore"):
        good = (ranges >= scan.range_min) & (ranges <= scan.range_max) & (ranges > 0.0)
        is_open = np.isposinf(ranges)
    return np.where(good, ranges, np.where(is_open, math.inf, math.nan))
