"""Test outdoor filters in worlds that differ from their model: python -m benchmarks.field.mismatches

Each mismatch is a world of `WORLDS`; the filter is always given `REFERENCE`. Runs drive the straight
course and the zigzag alternately. NEES in two dimensions (2 for a true claim), the radius that holds 95 %,
and the median claim are those of all places. DEPLOY does not lay where the fixes of the last minute
contradict the claim; of the sensors that it lays, the share further off than three claimed sigma (1.1 %
for normal errors).
"""

from __future__ import annotations

import argparse
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.field.field_course import straight_course, zigzag_course
from benchmarks.field.field_log import record_course
from benchmarks.field.field_trial import FieldTrial, start_pose, try_course
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.placement_errors import nees

NOISE_WORLDS = {
    "as told": REFERENCE_NOISE,
    "drift": REFERENCE_NOISE._replace(gps_drift=0.5, gps_drift_time=600.0),
    "slip": REFERENCE_NOISE._replace(turn_slip=0.30, slip=0.012, side_slip=3.0 * REFERENCE_NOISE.side_slip),
    "scale": REFERENCE_NOISE._replace(scale=0.015),
    "heading": REFERENCE_NOISE._replace(start_heading=math.radians(5.0)),
    "outages": REFERENCE_NOISE._replace(outage_every=120.0, outage_time=60.0),
    "jumps": REFERENCE_NOISE._replace(jump_every=60.0, jump=3.0),
    "delay": REFERENCE_NOISE._replace(gps_delay=0.5),
    "antenna": REFERENCE_NOISE._replace(antenna=(0.3, 0.2, 1.0)),
    "creep": REFERENCE_NOISE._replace(creep=0.001),
    "multipath": REFERENCE_NOISE._replace(multipath_every=180.0, outliers=0.03),
    "gyro bias": REFERENCE_NOISE._replace(
        gyro_bias=5.0 * REFERENCE_NOISE.gyro_bias, gyro_walk=5.0 * REFERENCE_NOISE.gyro_walk
    ),
    "tyre": REFERENCE_NOISE._replace(tyre=0.03),
}


def one_run(job: tuple[str, int]) -> FieldTrial:
    """Drive once through a world; the filter is given `REFERENCE_NOISE`."""
    world, seed = job
    log = record_course((straight_course, zigzag_course)[seed % 2](), NOISE_WORLDS[world], seed)
    return try_course(log, GpsFilter(start_pose(log)))


def row(world: str, trials: list[FieldTrial]) -> list[str]:
    """Return the table's line of one world."""
    squares = [nees(trial.errors, trial.covariances) for trial in trials]
    errors = np.concatenate([np.hypot(*trial.errors.T) for trial in trials])
    claims = np.concatenate([np.sqrt(np.trace(trial.covariances, axis1=1, axis2=2)) for trial in trials])
    means = np.array([run.mean() for run in squares])
    laid = np.concatenate([trial.consistent for trial in trials])
    beyond = 100.0 * float((np.concatenate(squares)[laid] > 9.0).mean())
    return [
        world,
        str(len(trials)),
        f"{means.mean():.2f} ± {means.std() / math.sqrt(len(means)):.2f}",
        f"{100.0 * laid.mean():.1f}",
        f"{beyond:.1f}",
        f"{1e3 * np.quantile(errors, 0.95):.0f}",
        f"{1e3 * np.median(claims):.0f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=200, help="of each world (default 200)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--world", action="append", choices=NOISE_WORLDS, help="this one alone")
    chosen = parser.parse_args()
    console = Console(width=None if sys.stdout.isatty() else 120)
    worlds = chosen.world or list(NOISE_WORLDS)
    jobs = [(world, seed) for world in worlds for seed in range(chosen.runs)]
    with ProcessPoolExecutor(chosen.jobs, get_context("spawn")) as pool:
        done = pool.map(one_run, jobs, chunksize=4)
        trials = list(track(done, "runs", total=len(jobs), console=Console(stderr=True)))
    table = Table(
        "world", "runs", "NEES (2)", "laid [%]", "beyond 3 sigma [%]", "r95 [mm]", "claimed, median [mm]"
    )
    for k, world in enumerate(worlds):
        table.add_row(*row(world, trials[k * chosen.runs : (k + 1) * chosen.runs]))
    console.print(table)


if __name__ == "__main__":
    main()
