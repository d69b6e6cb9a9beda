"""Measure the accuracy of positions and biases from beacon ranges: python -m benchmarks.field.beacons

Three beacons stand beside the zigzag course, each with its own bias. The filter estimates the biases,
which may wander or not; or it supposes that there are none. Worlds: constant biases; wandering biases; a
beacon that is moved half way through. Errors are those of all places where a sensor is laid; NEES is 2 for
honest claims, `beyond` the share of laid sensors that are more than three claimed sigma off.
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

from benchmarks.field.field_course import zigzag_course
from benchmarks.field.field_drive import PERIOD_S
from benchmarks.field.field_log import FieldLog, record_course
from benchmarks.field.field_trial import start_pose
from handcart.robotics.geometry.transform import rotations
from handcart.robotics.navigation.beacons.beacon_errors import BeaconErrors
from handcart.robotics.navigation.beacons.beacon_filter import BeaconFilter
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.placement_errors import nees
from handcart.robotics.numerics.arrays import FloatArray

BEACON_POSITIONS_M = np.array([[-5.0, 20.0, 2.0], [75.0, 25.0, 2.5], [35.0, -20.0, 1.5]])
BEACON_ERRORS = BeaconErrors(BEACON_POSITIONS_M, (0.0, 0.0, 1.0), scale=0.002)
MEASUREMENT_PERIODS = 8  # periods between measurements


class BeaconWorld(NamedTuple):
    """True errors of beacons."""

    bias_walk: float = 0.0
    """Random walk of each beacon's bias [m/√s]."""
    moved: float = 0.0
    """Distance by which the first beacon is moved half way through [m]."""


BEACON_WORLDS = {
    "constant biases": BeaconWorld(),
    "biases wander, 10 mm/√s": BeaconWorld(bias_walk=0.010),
    "a beacon is moved by 0.5 m": BeaconWorld(moved=0.5),
    "a beacon is moved by 3 m": BeaconWorld(moved=3.0),
}


class BeaconDrive(NamedTuple):
    """A drive, and the measured ranges to beacons."""

    log: FieldLog
    ranges: FloatArray
    """(n, k) in [m]; NaN in rows without a measurement."""
    biases: FloatArray
    """(k,) in the end, in [m]."""


def beacon_drive(seed: int, world: BeaconWorld = BeaconWorld(), stops: int = 7) -> BeaconDrive:
    """Return the zigzag course, driven."""
    log, rng = record_course(zigzag_course(stops), REFERENCE_NOISE, seed), np.random.default_rng([seed, 77])
    poses, tilts = log.drive.poses, log.drive.tilts
    tags = rotations(tilts[:, 0], tilts[:, 1], poses[:, 2]) @ np.array(BEACON_ERRORS.tag)
    tags[:, :2] += poses[:, :2]
    rows = np.arange(0, len(poses), MEASUREMENT_PERIODS)
    steps = (
        world.bias_walk
        * math.sqrt(MEASUREMENT_PERIODS * PERIOD_S)
        * rng.standard_normal((len(rows), len(BEACON_POSITIONS_M)))
    )
    biases = BEACON_ERRORS.bias * rng.standard_normal(len(BEACON_POSITIONS_M)) + np.cumsum(steps, axis=0)
    places = np.repeat(BEACON_POSITIONS_M[None], len(rows), axis=0)
    places[len(rows) // 2 :, 0, 1] += world.moved
    ranges = np.full((len(poses), len(BEACON_POSITIONS_M)), math.nan)
    scale = 1.0 + BEACON_ERRORS.scale * rng.standard_normal()
    ranges[rows] = scale * np.linalg.norm(places - tags[rows, None], axis=2) + biases
    ranges[rows] += BEACON_ERRORS.white * rng.standard_normal((len(rows), len(BEACON_POSITIONS_M)))
    return BeaconDrive(log, ranges, biases[-1])


class BeaconTrial(NamedTuple):
    """Result of a filter on one drive."""

    errors: FloatArray
    """(m, 2) in [m] of the places where sensors are laid."""
    covariances: FloatArray
    """(m, 2, 2) of them, as claimed."""
    biases: FloatArray
    """(k,) error of the biases in the end, in [m]."""
    refused: float
    """Share of the ranges."""
    consistent: list[bool]
    """(m,) whether ranges didn't contradict the claim."""


def try_beacons(drive: BeaconDrive, errors: BeaconErrors = BEACON_ERRORS) -> BeaconTrial:
    """Play a drive to a filter that believes `errors` of the ranges."""
    log, filtering = drive.log, BeaconFilter(start_pose(drive.log), REFERENCE_NOISE, errors)
    found, spreads, consistent = [], [], []
    placings = set(log.drive.placings.tolist())
    for row in range(len(log.rates)):
        filtering.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if np.isfinite(drive.ranges[row]).any():
            filtering.ranges(drive.ranges[row])
        if row in placings:
            found.append(np.array(filtering.pose)[:2] - log.drive.poses[row, :2])
            spreads.append(filtering.covariance[:2, :2])
            consistent.append(filtering.inconsistency is None)
    refused = filtering.refused / float(np.isfinite(drive.ranges).sum())
    off = filtering.biases.mean - drive.biases
    return BeaconTrial(np.array(found), np.array(spreads), off, refused, consistent)


def row_of(world: str, filtering: str, trials: list[BeaconTrial]) -> list[str]:
    """Return the table's line."""
    errors = np.concatenate([trial.errors for trial in trials])
    squares = nees(errors, np.concatenate([trial.covariances for trial in trials]))
    laid = np.concatenate([trial.consistent for trial in trials])
    biases = np.concatenate([trial.biases for trial in trials])
    return [
        world,
        filtering,
        f"{1e3 * np.quantile(np.hypot(*errors.T), 0.95):.0f}",
        f"{squares.mean():.2f}",
        f"{1e3 * math.sqrt((biases**2).mean()):.0f}",
        f"{100.0 * np.mean([trial.refused for trial in trials]):.1f}",
        f"{100.0 * laid.mean():.0f}",
        f"{100.0 * (squares[laid] > 9.0).mean() if laid.any() else 0.0:.1f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=40, help="of each world (default 40)")
    chosen = parser.parse_args()
    ways = {
        "biases that may wander": BEACON_ERRORS,
        "constant biases": BEACON_ERRORS._replace(bias_walk=0.0),
        "no biases": BEACON_ERRORS._replace(bias=0.005, bias_walk=0.0),
    }
    table = Table(
        "world", "supposed", "r95 [mm]", "NEES", "bias [mm]", "refused [%]", "laid [%]", "beyond [%]"
    )
    trials: dict[tuple[str, str], list[BeaconTrial]] = {}
    jobs = [(world, seed) for world in BEACON_WORLDS for seed in range(chosen.runs)]
    for world, seed in track(jobs, "runs", console=Console(stderr=True)):
        drive = beacon_drive(seed, BEACON_WORLDS[world])
        for way, errors in ways.items():
            trials.setdefault((world, way), []).append(try_beacons(drive, errors))
    for (world, way), found in trials.items():
        table.add_row(*row_of(world, way, found))
    Console(width=None if sys.stdout.isatty() else 130).print(table)


if __name__ == "__main__":
    main()
