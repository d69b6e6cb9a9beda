"""Check of a lidar's direction of counting: while the base turns, the scan turns the other way."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.capabilities.scan import Scan
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.evaluation.bringup.rung import RungFailed
from handcart.robotics.numerics.arrays import FloatArray

from .ros_site import RosSite

MIN_BEAMS = 20
CLEARLY = 0.5
"""Maximum ratio of the errors of both directions at which the one with the smaller error is accepted."""
MIN_ERROR = 0.02
"""Relative error of ranges below which both directions look alike."""


def scan_of(backend: RosBackend) -> Scan | None:
    """Return the last scan that the robot's lidar delivered; None if the robot has no lidar."""
    lidar = backend.get(RangeSensor)  # type: ignore[type-abstract]
    return None if lidar is None else lidar.scan()


def check_side(site: RosSite, before: Scan | None, after: Scan | None, turn: float) -> None:
    """Check that the lidar's scan turns in the opposite direction to the base.

    Args:
        site: robot or bench.
        before: the scan before the turn; None without a lidar.
        after: the scan after it.
        turn: angle by which the base turned on the spot, in [rad], positive to the left.

    Raises:
        RungFailed: the scan turned with the base, or fits both directions, as in a round room or with few
            returns.
    """
    if before is None or after is None:
        return
    right, mirrored = shift_error(before, after, turn), shift_error(before, after, -turn)
    turned = f"{site.spec.lidar.topic}: the base turned by {math.degrees(turn):.0f} deg, and"
    if mirrored < CLEARLY * right and right > MIN_ERROR:
        mends = f"upside_down: {str(not site.spec.lidar.upside_down).lower()}"
        raise RungFailed(
            f"{turned} what the lidar sees turned with it instead of against it ({mirrored:.1%} error,"
            f" {right:.1%} the other way); it counts the wrong way round; `{mends}` in the file's section"
            " `ros2`, under `lidar`, mends it"
        )
    if not (right < CLEARLY * mirrored and mirrored > MIN_ERROR):
        both = f"{right:.1%} and {mirrored:.1%} error"
        if math.isnan(right) or math.isnan(mirrored):
            both = f"fewer than {MIN_BEAMS} beams return both times"
        raise RungFailed(
            f"{turned} it can't be determined which way round the lidar counts: what it sees fits both ways"
            f" ({both}), as in a round room; put a box beside the base, within its view, and repeat the step"
        )


def shift_error(before: Scan, after: Scan, turn: float) -> float:
    """Return the median relative difference of the ranges of two scans between which the lidar turned.

    Args:
        before: scan before the turn.
        after: scan after the turn.
        turn: assumed turn, in [rad], positive to the left.

    Returns:
        Median of the absolute logarithms of the ranges' ratios, without unit; NaN if few beams can be
            compared.
    """
    seen = _ranges_at(before, after.angles + turn)
    both = np.isfinite(seen) & np.isfinite(after.ranges) & (seen > 0.0) & (after.ranges > 0.0)
    if np.count_nonzero(both) < MIN_BEAMS:
        return math.nan
    return float(np.median(np.abs(np.log(after.ranges[both] / seen[both]))))


def _ranges_at(scan: Scan, angles: FloatArray) -> FloatArray:
    """Return the ranges (n,) of the beams nearest to angles (n,) in [rad]; NaN beside the fan."""
    step = float(scan.angles[1] - scan.angles[0])
    off = np.mod(angles - float(scan.angles[0]), math.tau)
    places = np.rint(off / step).astype(int)
    inside = places < len(scan.ranges)
    found = np.full(len(angles), math.nan)
    found[inside] = scan.ranges[places[inside]]
    return found
