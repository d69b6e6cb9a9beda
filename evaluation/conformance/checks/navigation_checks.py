"""Check of what localization relies on: scans and wheels agree on how the base moves, at the same time.

No ground truth is needed. Each scan is matched with the first one, and the motion that the scans show is
compared with that of the wheels: scans that are dropped, late or mirrored, and wheels that report another
motion than the base's, show in it.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.localization.lidar import Lidar
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import SETTLING_PERIODS, drivable, steps
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.evaluation.trials.rig import Rig
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.odometry.odometry import Odometry
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import match_scan
from handcart.robotics.numerics.arrays import FloatArray

from .check import Check, CheckResult

TURN_RATE, SPEED = 0.5, 0.15  # [rad/s], [m/s]
LEG_S = 1.2  # of driving one way
MIN_POINTS = 30  # of a scan, to be followed
MIN_INLIERS = 0.4  # share of a scan that the first one explains, at least
STEP_SIGMAS = np.diag([0.03, 0.03, 0.04]) ** 2  # [m², rad²] of the motion in a period
CELL_M, WINDOW_M = 0.04, 24.0  # of the grid that the first scan is drawn on
MAX_LATE_S = 0.1
MAX_LAG_S = 0.6  # that is tried
MAX_REPEATED = 0.2  # share of the scans that may be that of the period before while the base drives
MAX_WRONG = 0.12  # of the wheels' turn or way, relative
ROLLED_M = 1e-3  # by a wheel, from which the base drives


class _Record(NamedTuple):
    """Readings of one period."""

    ranges: FloatArray
    points: FloatArray
    """Points (n, 2) of the scan in the base frame, in [m]."""
    left: float
    """Travel of the left wheel so far, in [m]."""
    right: float


def navigation(bench: KitBench, finding: CheckResult) -> None:
    """Check that the motion estimated from lidar scans agrees with the motion measured by the wheels.

    The base turns both ways and drives ahead and back.
    """
    with bench.rig() as rig:
        spec = rig.robot.spec
        records = _driven(rig)
        wheels = _by_wheels(records, spec.drive.tread_m)
        if np.ptp(wheels[:, 2]) < 0.1:
            raise Skipped("the base does not turn in this world")
        _count_repeated(records, finding)
        noise = max(0.01, spec.range_sensor.sigma_mm / 1e3) if spec.range_sensor else 0.01
        seen = _by_scans(records, noise)
        if seen is None:
            finding.expect(False, "scans taken one after the other show different places")
            return
        _compare(wheels, seen, rig.backend.period, finding)


def _driven(rig: Rig) -> list[_Record]:
    """Return the readings of a drive to the left, to the right, ahead and back."""
    backend, spec = rig.backend, rig.robot.spec
    base, lidar = needed(backend, Base), Lidar(needed(backend, RangeSensor), spec)
    steps(backend, SETTLING_PERIODS)
    legs = [(0.0, TURN_RATE), (0.0, -TURN_RATE), (SPEED, 0.0), (-SPEED, 0.0)]
    records: list[_Record] = []
    for speed, turn_rate in legs:
        command = drivable(spec, speed, turn_rate)
        for period in range(round(LEG_S / backend.period) + SETTLING_PERIODS):
            if period < round(LEG_S / backend.period):
                base.drive(*command)
            backend.step()
            scan, travel = lidar.scan(), base.wheel_travel()
            records.append(_Record(scan.ranges.copy(), scan.points(), travel.left, travel.right))
    return records


def _by_wheels(records: list[_Record], tread: float) -> FloatArray:
    """Return poses (n, 3) of the base by the wheels, in the frame of the first one.

    Args:
        records: n readings.
        tread: distance between the wheels, in [m].

    Returns:
        x, y in [m] and heading in [rad]; headings are not wrapped.
    """
    odometry, poses = Odometry(Pose2(0.0, 0.0, 0.0), tread), [np.zeros(3)]
    for before, now in pairwise(records):
        odometry.predict(now.left - before.left, now.right - before.right)
        poses.append(np.array(odometry.pose))
    return _unwrapped(np.array(poses))


def _by_scans(records: list[_Record], noise: float) -> FloatArray | None:
    """Return poses (n, 3) of the base by matching each scan with the first one; None if a scan does not
    match.

    Args:
        records: n readings.
        noise: standard deviation of a range, in [m].

    Returns:
        x, y in [m] and heading in [rad] in the frame of the first scan's base; headings are not wrapped.
    """
    first = records[0].points
    if len(first) < MIN_POINTS:
        raise Skipped("the lidar sees next to nothing in this world")
    count = round(WINDOW_M / CELL_M)
    nothing = np.zeros((count, count), dtype=np.bool_)
    grid = GridMap(nothing, nothing, CELL_M, -WINDOW_M / 2, -WINDOW_M / 2)
    field, pose, poses = LikelihoodField(grid.with_points(first), is_drawn=True), Pose2(0.0, 0.0, 0.0), []
    for record in records:
        match = match_scan(field, record.points, pose, STEP_SIGMAS, noise)
        if len(record.points) >= MIN_POINTS and match.inliers < MIN_INLIERS:
            return None
        pose = match.pose
        poses.append(np.array(pose))
    return _unwrapped(np.array(poses))


def _unwrapped(poses: FloatArray) -> FloatArray:
    poses[:, 2] = np.unwrap(poses[:, 2])
    return poses


def _count_repeated(records: list[_Record], finding: CheckResult) -> None:
    """Check how many scans are missing, or repeat the previous scan, while the wheels roll."""
    repeated = rolling = 0
    for before, now in pairwise(records):
        if max(abs(now.left - before.left), abs(now.right - before.right)) > ROLLED_M:
            rolling += 1
            repeated += np.array_equal(before.ranges, now.ranges, equal_nan=True) or not len(now.points)
    finding.at_most("scans repeated or missing while it drives", repeated / max(1, rolling), MAX_REPEATED)


def _compare(wheels: FloatArray, seen: FloatArray, period: float, finding: CheckResult) -> None:
    """Compare the motions by wheels and by scans: sense and size of the turns, delay, and distance driven
    ahead.

    Args:
        wheels: (n, 3) poses by the wheels, x, y in [m] and heading in [rad].
        seen: (n, 3) poses by the scans.
        period: time between two poses, in [s].
        finding: receives the violations.
    """
    times = period * np.arange(len(wheels))
    lags = np.arange(0.0, MAX_LAG_S, period / 4)
    fits = [_fitted(np.interp(times - lag, times, wheels[:, 2]), seen[:, 2]) for lag in lags]
    best = int(np.argmin([rest for rest, _ in fits]))
    late, ratio = float(lags[best]), fits[best][1]
    if ratio < 0.0:
        finding.expect(False, "scans turn the other way than wheels: scans are mirrored, or wheels swapped")
        return
    finding.at_most("scans late", late, MAX_LATE_S, "s")
    finding.at_most("turn by wheels off", abs(ratio - 1.0), MAX_WRONG)
    half = len(wheels) // 2
    far_wheels, far_seen = (float(np.ptp(poses[half:] @ _ahead(poses))) for poses in (wheels, seen))
    finding.at_most("way by wheels off", abs(far_wheels / max(far_seen, 1e-3) - 1.0), MAX_WRONG)


def _fitted(wheels: FloatArray, seen: FloatArray) -> tuple[float, float]:
    """Fit headings by scans to headings by wheels, (n,) in [rad]; return the residual sum of squares and
    their ratio.
    """
    wheels, seen = wheels - wheels.mean(), seen - seen.mean()
    ratio = float(wheels @ seen) / max(float(wheels @ wheels), 1e-9)
    return float(((seen - ratio * wheels) ** 2).sum()), ratio


def _ahead(poses: FloatArray) -> FloatArray:
    """Return the direction of driving ahead (3,), as unit vector of x and y, then 0, to project poses on.

    It is that of the median heading in the second half of poses (n, 3), x, y in [m] and heading in [rad].
    """
    heading = float(np.median(poses[len(poses) // 2 :, 2]))
    return np.array([math.cos(heading), math.sin(heading), 0.0])


CHECKS = (Check("navigation", "scans and wheels agree on how the base moves, at the same time", navigation),)
