"""Start with an unknown heading: python -m benchmarks.field.headings [--runs N] [--jobs N]

Runs drive the straight course and the zigzag alternately, through the worlds of
`benchmarks.field.mismatches` one after the other, and start with a random heading. Prints the driving time
until the heading is known, the number of drives in which it is reported as unknown until the end, and how
often the claim is off by more than three sigma.
"""

from __future__ import annotations

import argparse
import math
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track

from benchmarks.field.field_course import straight_course, zigzag_course
from benchmarks.field.field_drive import PERIOD_S, FieldTimes
from benchmarks.field.field_log import record_course
from benchmarks.field.mismatches import NOISE_WORLDS
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter

FIELD_TIMES = FieldTimes(wait=10.0, dwell=5.0)
DRIVING_TIME_S = 60.0  # [s] of driving


class Start(NamedTuple):
    """One drive until the heading is known, or for as long as it lasts."""

    seconds: float
    """Driving time until the heading was known [s]; infinite: never, and reported so."""
    off: float
    """Then, in claimed sigmas."""
    wrong: bool
    """It was claimed to be known before, and was off by more than three sigma, at `DRIVING_TIME_S`."""


def one_run(seed: int) -> Start:
    """One drive through the world that the seed picks."""
    world = list(NOISE_WORLDS)[seed % len(NOISE_WORLDS)]
    course = (straight_course, zigzag_course)[seed // len(NOISE_WORLDS) % 2](4)
    log = record_course(course, NOISE_WORLDS[world], seed, FIELD_TIMES)
    heading = float(np.random.default_rng([seed, 77]).uniform(-math.pi, math.pi))
    localizer = GpsFilter(Pose2(0.0, 0.0, heading), REFERENCE_NOISE._replace(start_heading=math.inf))
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    drove, known, first = 0.0, math.inf, math.inf
    for row in range(len(log.rates)):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])
        drove += PERIOD_S * bool(log.drive.driven[row, 0] > 0.0)
        if localizer.heading_known and math.isinf(known):
            known, first = drove, _off(localizer, float(log.drive.poses[row, 2]))
        if drove >= DRIVING_TIME_S:
            break
    wrong = localizer.heading_known and _off(localizer, float(log.drive.poses[row, 2])) > 3.0
    return Start(known, first, wrong)


def _off(localizer: GpsFilter, truth: float) -> float:
    return abs(wrap(localizer.pose.theta - truth)) / math.sqrt(float(localizer.covariance[2, 2]))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=500, help="default 500")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    chosen = parser.parse_args()
    with ProcessPoolExecutor(chosen.jobs, get_context("spawn")) as pool:
        done = pool.map(one_run, range(chosen.runs), chunksize=4)
        starts = list(track(done, "runs", total=chosen.runs, console=Console(stderr=True)))
    seconds = np.array([start.seconds for start in starts])
    known = np.isfinite(seconds)
    print(f"{len(starts)} starts; known after {np.median(seconds):.1f} s of driving in the median", end="; ")
    print(
        f"within 30 s {int((seconds <= 30.0).sum())}, within {DRIVING_TIME_S:.0f} s {int(known.sum())}",
        end=", ",
    )
    print(f"else said to be unknown: {int((~known).sum())}")
    beyond = sum(start.off > 3.0 for start in starts if math.isfinite(start.seconds))
    print(f"beyond three claimed sigma when first known: {beyond}; after {DRIVING_TIME_S:.0f} s: ", end="")
    print(sum(start.wrong for start in starts))


if __name__ == "__main__":
    main()
