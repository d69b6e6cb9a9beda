"""Measure how well the displacement of a base is known: python -m benchmarks.field.displacements

Straight courses are driven. An origin is set at each stop, where DEPLOY would lay; the filter's
displacement from there to a later stop is compared with the truth. Beside it, the result without the
cloned pose: the difference of two poses, each with its claimed covariance. The filter is always given
`REFERENCE`; worlds are as given, and otherwise (see `benchmarks.field.mismatches`). NEES is 2 for honest
claims; `beyond` is the share that is further off than three claimed sigma along the worst direction.
"""

from __future__ import annotations

import argparse
import math
import sys
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.field.field_course import straight_course
from benchmarks.field.field_drive import PERIOD_S
from benchmarks.field.field_log import FieldLog, record_course
from benchmarks.field.field_trial import start_pose
from benchmarks.field.mismatches import NOISE_WORLDS
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.placement_errors import nees
from handcart.robotics.numerics.arrays import FloatArray

LEG_COUNTS = (0, 1, 2, 4)  # of ten metres, from stop to stop; 0 at a stop


class Way(NamedTuple):
    """Displacement from one stop to a later one."""

    error: FloatArray
    """(2,) of what is said of it, in [m]."""
    covariance: FloatArray
    """(2, 2) that is claimed of it, in [m²]."""
    pose_error: FloatArray
    """(2,) of the difference of the two poses, in [m]."""


def ways(log: FieldLog, legs: int) -> list[Way]:
    """Return the displacements of one drive over `legs` legs each."""
    localizer = GpsFilter(start_pose(log), REFERENCE_NOISE)
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    ends = log.drive.placings.tolist()[:: max(1, legs)] if legs else log.drive.placings.tolist()
    begins = {row - round(9.0 / PERIOD_S) for row in ends} if legs == 0 else set(ends)
    found: list[Way] = []
    begun: tuple[int, FloatArray] | None = None
    for row in range(max(ends) + 1):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])
        if begun is not None and row in ends:
            found.append(_way(log, localizer, *begun, row))
        if row in begins:
            localizer.set_origin()
            begun = row, np.array(localizer.pose)
    return found


def _way(log: FieldLog, localizer: GpsFilter, begun: int, pose: FloatArray, row: int) -> Way:
    way = log.drive.poses[row, :2] - log.drive.poses[begun, :2]
    mean, covariance = localizer.displacement
    error = mean[:2] - true_way(log, begun, row)[:2]
    return Way(error, covariance[:2, :2], np.array(localizer.pose)[:2] - pose[:2] - way)


def true_way(log: FieldLog, begun: int, row: int) -> FloatArray:
    """Return (3,) x ahead, y left in [m], turn in [rad], from one row to a later one."""
    begin, end = (Pose2(*log.drive.poses[item].tolist()) for item in (begun, row))
    return np.array(end.relative_to(begin))


def row_of(world: str, legs: int, found: list[Way]) -> list[str]:
    """Return the table's line."""
    errors = np.array([way.error for way in found])
    covariances = np.array([way.covariance for way in found])
    worst = np.sqrt(np.maximum(0.0, np.linalg.eigvalsh(covariances)[:, -1]))
    away = np.hypot(*errors.T)
    floor = 1e-6 * np.eye(2)  # a base at rest is known to be at rest
    return [
        world,
        f"{10 * legs} m" if legs else "0 m, 9 s",
        str(len(found)),
        f"{1e3 * math.sqrt((away**2).mean()):.0f}",
        f"{1e3 * math.sqrt((np.array([way.pose_error for way in found]) ** 2).sum(axis=1).mean()):.0f}",
        f"{3e3 * np.median(worst):.0f}",
        f"{3e3 * np.quantile(worst, 0.95):.0f}",
        f"{nees(errors, covariances + floor).mean():.2f}",
        f"{100.0 * (away > 3.0 * worst + 1e-3).mean():.1f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=20, help="of each world and length (default 20)")
    parser.add_argument("--world", action="append", choices=NOISE_WORLDS, help="this one alone")
    chosen = parser.parse_args()
    table = Table(
        "world", "way", "ways", "RMS [mm]", "of poses [mm]", "3 sigma [mm]", "95 %", "NEES", "beyond [%]"
    )
    jobs = [(world, legs) for world in chosen.world or NOISE_WORLDS for legs in LEG_COUNTS]
    for world, legs in track(jobs, "worlds", console=Console(stderr=True)):
        logs = (record_course(straight_course(), NOISE_WORLDS[world], seed) for seed in range(chosen.runs))
        table.add_row(*row_of(world, legs, [way for log in logs for way in ways(log, legs)]))
    Console(width=None if sys.stdout.isatty() else 120).print(table)


if __name__ == "__main__":
    main()
