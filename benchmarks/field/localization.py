"""Measure how well sensors are laid outdoors: python benchmarks/field/localization.py [--runs N] [--raw CSV]

Two courses, 17 targets in a row and 7 in a zigzag, with the noise of `FieldNoise`. An error is the
position of a laid sensor less its target, with an exact arm. Printed beside it: the measurements of Ohki
et al. (2012), and the information limit, which no filter can beat with these sensors. Values in brackets
are bootstrap 95 % intervals over whole runs; a band is 10 to 90 % of the runs. "turned" starts with a
heading that is half a turn off; its placements before the filter notices count too.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from handcart.robotics.numerics.arrays import FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.field.field_course import FieldCourse, straight_course, zigzag_course
from benchmarks.field.field_log import FieldLog, record_course
from benchmarks.field.field_trial import FieldTrial, as_laid, start_pose, try_course
from benchmarks.field.information_limit import information_limit
from benchmarks.field.placement_radius import share_radius, tip_covariance
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import (
    REALISTIC_NOISE,
    REFERENCE_NOISE,
    RTK_NOISE,
    FieldNoise,
)
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.particle_filter import ParticleFilter
from handcart.robotics.navigation.outdoors.placement_errors import aligned_spread, nees

COURSE_MAKERS: dict[str, Callable[[], FieldCourse]] = {"straight": straight_course, "zigzag": zigzag_course}
PAPER_ERRORS_MM = {"straight": (58.0, 148.0), "zigzag": (283.0, 123.0)}  # [mm], along and across
WHOLE_SETS = ("REF", "RTK")  # noise sets that all runs are made of; a quarter for the others
REFLECTED_NOISE = REFERENCE_NOISE._replace(multipath_every=180.0, outliers=0.03)
SILENT_NOISE = REFERENCE_NOISE._replace(outage_every=120.0, outage_time=60.0)
NOISE_SETS = {
    "REF": REFERENCE_NOISE,
    "RTK": RTK_NOISE,
    "REAL": REALISTIC_NOISE,
    "reflections": REFLECTED_NOISE,
    "outages": SILENT_NOISE,
}
CHI2_95 = 5.991  # two degrees of freedom


class Key(NamedTuple):
    """One line of the table."""

    noise: str
    course: str
    way: str


Results = dict[Key, list[FieldTrial]]


def one_run(job: tuple[str, str, int]) -> list[tuple[Key, FieldTrial]]:
    """Return all ways of localizing on one log."""
    name, course, seed = job
    noise = NOISE_SETS.get(name, REFERENCE_NOISE)
    log = record_course(COURSE_MAKERS[course](), noise, seed)
    start = start_pose(log)
    if name == "turned":
        start = Pose2(0.0, 0.0, start.theta + math.pi)
    localizer = GpsFilter(start, noise, record=True)
    trials = {"Kalman": try_course(log, localizer)}
    trials["Kalman, as laid"] = as_laid(log, localizer.smoothed())
    trials["limit"] = limit(log, noise)
    if name == "REF":
        trials["paper's filter"] = try_course(log, ParticleFilter(start, seed=seed, euler=False))
        trials["its filter, Euler"] = try_course(log, ParticleFilter(start, seed=seed))
    return [(Key(name, course, way), trial) for way, trial in trials.items()]


def limit(log: FieldLog, noise: FieldNoise) -> FieldTrial:
    """Return the bound as a trial whose errors are not known."""
    bounds = information_limit(log.drive, log.fix_rows, noise)
    headings = log.drive.poses[log.drive.placings, 2]
    spreads = [tip_covariance(bound, float(angle)) for bound, angle in zip(bounds, headings, strict=True)]
    return FieldTrial(np.full((len(spreads), 2), np.nan), np.array(spreads))


def bootstrap(runs: list[FieldTrial], figure: Callable[[list[FieldTrial]], float]) -> tuple[float, float]:
    """Return the 95 % interval of a figure by resampling whole runs."""
    rng = np.random.default_rng(0)
    drawn = [figure([runs[k] for k in rng.integers(0, len(runs), len(runs))]) for _ in range(300)]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return float(low), float(high)


def mean_nees(runs: list[FieldTrial]) -> float:
    """Return the mean NEES of all placements: 2 for an honest covariance."""
    return float(np.mean([nees(run.errors, run.covariances).mean() for run in runs]))


def coverage(runs: list[FieldTrial]) -> float:
    """Share of the placements inside their 95 % ellipse, in percent."""
    inside = [nees(run.errors, run.covariances) < CHI2_95 for run in runs]
    return 100.0 * float(np.concatenate(inside).mean())


def rms(runs: list[FieldTrial]) -> FloatArray:
    """Return (2,) in [mm]."""
    return 1e3 * np.asarray(np.sqrt((np.concatenate([run.errors for run in runs]) ** 2).mean(axis=0)))


def believed(runs: list[FieldTrial]) -> FloatArray:
    """Return (2,) what the covariances say of it, in [mm]."""
    variances = np.concatenate([run.covariances for run in runs])[:, [0, 1], [0, 1]]
    return 1e3 * np.asarray(np.sqrt(variances.mean(axis=0)))


def pair(values: FloatArray, form: str = ".0f") -> str:
    return f"{values[0]:{form}} / {values[1]:{form}}"


def spreads(results: Results) -> Table:
    """Aligned standard deviations as the paper has them."""
    table = Table("noise", "course", "way", "runs", "SD x / y [mm]", "band x", "band y", "paper")
    table.title = "Aligned standard deviations, median of the runs"
    for key, runs in results.items():
        if key.way == "limit":
            continue
        targets = COURSE_MAKERS[key.course]().targets
        values = 1e3 * np.array([aligned_spread(run.errors, targets) for run in runs])
        bands = np.percentile(values, [10, 90], axis=0).T
        paper = PAPER_ERRORS_MM[key.course] if key.noise == "REF" else ()
        inside = [low <= value <= high for (low, high), value in zip(bands, paper, strict=False)]
        said = " / ".join(f"{v:.0f} {'in' if i else 'OUT'}" for v, i in zip(paper, inside, strict=True))
        row = [*key, str(len(runs)), pair(np.median(values, axis=0))]
        table.add_row(*row, *(f"{low:.0f}-{high:.0f}" for low, high in bands), said)
    return table


def errors(results: Results) -> Table:
    """Return a table of errors, against the information limit and the claims."""
    table = Table(
        "noise", "course", "way", "RMS x / y [mm]", "/ limit", "NEES (2)", "in 95 % [%]", "r95 [mm]", "r99.7"
    )
    table.title = "Errors of all placements"
    for key, runs in results.items():
        if key.way == "limit":
            table.add_row(*key, pair(believed(runs)), "1", *[""] * 4)
            continue
        best = believed(results[Key(key.noise, key.course, "limit")])
        low, high = bootstrap(runs, mean_nees)
        few, many = bootstrap(runs, coverage)
        row = [*key, pair(rms(runs)), pair(rms(runs) / best, ".2f")]
        row += [
            f"{mean_nees(runs):.2f} [{low:.2f}-{high:.2f}]",
            f"{coverage(runs):.1f} [{few:.1f}-{many:.1f}]",
        ]
        table.add_row(*row, radius(runs, 0.95), radius(runs, 0.997))
    return table


def radius(runs: list[FieldTrial], share: float) -> str:
    found = share_radius([run.errors for run in runs], share)
    if found is None:
        return "too few"
    return f"{1e3 * found.radius:.0f} [{1e3 * found.low:.0f}-{1e3 * found.high:.0f}]"


def write_raw(path: Path, results: Results) -> None:
    """One row a placement."""
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["noise", "course", "way", "run", "placement", "x_mm", "y_mm", "nees"])
        for key, runs in results.items():
            for number, run in enumerate(runs if key.way != "limit" else []):
                squares = nees(run.errors, run.covariances)
                for place, (error, square) in enumerate(zip(1e3 * run.errors, squares, strict=True), 1):
                    rows.writerow([*key, number, place, *(f"{v:.1f}" for v in error), f"{square:.2f}"])


def measure(runs: int, jobs: int, console: Console) -> Results:
    """Return every noise set on both courses; the same seeds for all."""
    work = [
        (name, course, seed)
        for name in (*NOISE_SETS, "turned")
        for course in COURSE_MAKERS
        for seed in range(runs if name in WHOLE_SETS else max(1, runs // 4))
    ]
    found: dict[tuple[str, str, int], list[tuple[Key, FieldTrial]]] = {}
    with Progress(console=console) as progress, ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        task = progress.add_task("runs", total=len(work))
        pending = {pool.submit(one_run, job): job for job in work}
        for done in as_completed(pending):
            found[pending[done]] = done.result()
            progress.advance(task)
    results: Results = {}
    for job in work:
        for key, trial in found[job]:
            results.setdefault(key, []).append(trial)
    return results


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=200, help="of each course and noise set (default 200)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--raw", type=Path, help="write each placement to this CSV file")
    chosen = parser.parse_args()
    console = Console(width=None if sys.stdout.isatty() else 150)
    results = measure(chosen.runs, chosen.jobs, console)
    console.print(spreads(results))
    console.print(errors(results))
    if chosen.raw:
        write_raw(chosen.raw, results)


if __name__ == "__main__":
    main()
