"""The one place where raw readings of a lidar become a scan whose beams have a validity."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.scan import Scan, Validity
from handcart.backends.description.range_spec import RangeSpec
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

WITHIN_FOOTPRINT_M = 0.05
"""Depth inside the footprint's edge, in [m], from which a return is the robot itself, or dirt."""


def read_scan(raw: Scan, spec: RangeSpec, footprint: Footprint) -> Scan:
    """Interpret a raw scan: return a scan in which each beam has its validity, and a finite range for a
    return.

    Never raises, whatever a driver delivers. By REP 117 infinity means no return, -infinity too close and
    NaN invalid; `RangeSpec.no_return` decides about zeros and readings below the minimum range.

    Args:
        raw: scan of the backend.
        spec: limits, masks and the driver's conventions, from the robot's file.
        footprint: outline of the robot; a return inside it, with a margin at the edge, is too close.
    """
    ranges = raw.ranges
    if not spec.masked_deg and (ranges > _least_sound(raw, spec, footprint.radius)).all():
        far = ranges > spec.reach_m
        return Scan(raw.angles, np.where(far, np.inf, ranges), raw.base_T_sensor, far.astype(np.uint8))
    validity = np.full(len(ranges), Validity.RETURN, np.uint8)
    missing = _missing(ranges, spec)
    validity[ranges < spec.range_min_m] = Validity.TOO_CLOSE  # -infinity too
    validity[(ranges > 0.0) & _within(raw, footprint)] = Validity.TOO_CLOSE
    zeros = np.isfinite(ranges) & (ranges <= 0.0)
    validity[zeros | np.isnan(ranges)] = Validity.INVALID
    validity[missing] = Validity.NO_RETURN
    if spec.masked_deg:
        validity[spec.masked(raw.angles)] = Validity.INVALID
    read = np.where(validity == Validity.RETURN, ranges, np.inf)
    return Scan(raw.angles, read, raw.base_T_sensor, validity)


def _least_sound(raw: Scan, spec: RangeSpec, footprint_radius: float) -> float:
    """Return the range in [m] beyond which no reading is too close, whatever its angle."""
    within = footprint_radius - WITHIN_FOOTPRINT_M + math.hypot(*raw.base_T_sensor[:2])
    return max(0.0, spec.range_min_m, within)


def _missing(ranges: FloatArray, spec: RangeSpec) -> BoolArray:
    """Return a mask (n,), True for beams without a return.

    Args:
        ranges: (n,) raw ranges in [m]; infinite, 0, NaN or below the minimum as the driver delivers them.
        spec: limits and the driver's conventions, from the robot's file.
    """
    missing: BoolArray = ranges > spec.reach_m
    if "zero" in spec.no_return:
        missing |= np.isfinite(ranges) & (ranges <= 0.0)
    if "below_min" in spec.no_return:
        missing |= (ranges > 0.0) & (ranges < spec.range_min_m)
    if "nan" in spec.no_return:
        missing |= np.isnan(ranges)
    return missing


def _within(raw: Scan, footprint: Footprint) -> BoolArray:
    """Return a mask (n,), True for readings that end well inside the footprint."""
    mount = raw.base_T_sensor
    reach = np.where(np.isfinite(raw.ranges), raw.ranges, 1e6)
    if footprint.is_disc and mount.x == 0.0 and mount.y == 0.0:
        return np.asarray(reach < footprint.radius - WITHIN_FOOTPRINT_M)
    angle = raw.angles + mount.theta
    points = np.column_stack([mount.x + reach * np.cos(angle), mount.y + reach * np.sin(angle)])
    return np.asarray(footprint.distances(points) < -WITHIN_FOOTPRINT_M)
