"""Evidence of a scan for and against a hypothesis of the pose on a map.

Each beam is explained, ends before what the map shows (an obstacle is there that the map lacks), or passes
through what the map shows. The last is the stronger evidence against a pose: things are added to a place
more often than walls are taken away. A simplified beam model after Thrun, Burgard and Fox (2005), section
6.3.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField, read_distance
from handcart.robotics.navigation.scans.scan_matching import CELL_SIGMA, INLIER_SCALES
from handcart.robotics.navigation.scans.start_search import SHORT_OF_REACH, ScanBeams, trace_ranges
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled

INDEPENDENT_RAD = math.radians(9.0)
"""Angle between beams that count as independent: neighbours see the same thing."""
SHORT_ODDS = 10.0
"""Odds that a beam is explained from the true pose, and not short, against those from another pose."""
THROUGH_ODDS = 100.0
"""Odds that a beam is explained from the true pose, and does not pass through what the map shows."""
MIN_SLACK_M = 0.15  # by which a range may exceed that to what the map shows
SLACK_RATIO = 0.02  # of the range, likewise
GRAZING_SLACK_M, GRAZING_SLACK_RATIO = 0.3, 0.1  # likewise where the beam ends at a surface of the map
MAX_BEAMS = 180


class Explained(NamedTuple):
    """Shares of a scan's beams that agree or disagree with the map, for each of n poses."""

    explained: FloatArray
    """(n,) share of the beams that the map explains, 0 to 1; beams that return nothing count too."""
    short: FloatArray
    """(n,) share of the beams that end before what the map shows, 0 to 1."""
    through: FloatArray
    """(n,) share of the beams that pass through what the map shows, 0 to 1."""
    independent: float
    """Number of independent beams in the scan."""

    @property
    def log_likelihood(self) -> FloatArray:
        """Natural logarithm of the likelihood (n,) of the scan at each of n poses; 0 if all beams agree with
        the map.
        """
        cost = math.log(SHORT_ODDS) * self.short + math.log(THROUGH_ODDS) * self.through
        return np.asarray(-self.independent * cost)


def matching_noise(field: LikelihoodField, sigma: float) -> float:
    """Return the standard deviation of a scan point's distance to the map, in [m].

    Args:
        field: likelihood field of the map; the size of its cells adds to the result.
        sigma: standard deviation of a range, in [m].
    """
    return math.hypot(sigma, CELL_SIGMA * field.map.resolution)


def thinned(beams: ScanBeams, most: int = MAX_BEAMS) -> ScanBeams:
    """Return a scan with at most `most` of its beams, chosen at even steps."""
    if len(beams.angles) <= most:
        return beams
    chosen = np.linspace(0, len(beams.angles) - 1, most).astype(np.int64)
    return beams._replace(angles=beams.angles[chosen], ranges=beams.ranges[chosen])


def independent_beams(beams: ScanBeams) -> float:
    """Return the number of sectors, each `INDEPENDENT_RAD` wide, in which a scan has a reading.

    Beams of different sectors count as independent measurements.
    """
    known = beams.angles[~np.isnan(beams.ranges)]
    return float(len(np.unique(np.floor(known / INDEPENDENT_RAD)))) if len(known) else 0.0


def explain(field: LikelihoodField, beams: ScanBeams, poses: FloatArray, noise: float) -> Explained:
    """Return which shares of a scan's beams agree or disagree with the map, for each of several poses.

    Args:
        field: likelihood field of the map.
        beams: beams of the scan.
        poses: (n, 3) map_T_base, in [m, m, rad].
        noise: sigma of a point's distance to the map, in [m].
    """
    few, grid = thinned(beams), field.map
    counts = _count(
        field.distance,
        grid.occupied,
        (grid.origin_x, grid.origin_y),
        grid.resolution,
        np.ascontiguousarray(poses, dtype=np.float64).reshape(-1, 3),
        np.asarray(few.origin, dtype=np.float64),
        np.ascontiguousarray(few.angles, dtype=np.float64),
        np.ascontiguousarray(few.ranges, dtype=np.float64),
        few.reach,
        INLIER_SCALES * noise,
    )
    shares = counts / max(1, int((~np.isnan(few.ranges)).sum()))
    return Explained(shares[:, 0], shares[:, 1], shares[:, 2], independent_beams(few))


@compiled
def _count(
    distance: SingleArray,
    occupied: BoolArray,
    corner: tuple[float, float],
    resolution: float,
    poses: FloatArray,
    origin: FloatArray,
    angles: FloatArray,
    ranges: FloatArray,
    reach: float,
    near: float,
) -> FloatArray:
    """Return (n, 3) numbers of beams that are explained, short, and through, from poses (n, 3)."""
    out = np.zeros((len(poses), 3))
    ends = np.empty((len(angles), 2))
    for m in range(len(poses)):
        theta = poses[m, 2]
        cos, sin = math.cos(theta), math.sin(theta)
        column = (poses[m, 0] + cos * origin[0] - sin * origin[1] - corner[0]) / resolution - 0.5
        row = (poses[m, 1] + sin * origin[0] + cos * origin[1] - corner[1]) / resolution - 0.5
        for i in range(len(angles)):
            way = ranges[i] / resolution if math.isfinite(ranges[i]) else 0.0
            ends[i, 0] = column + way * math.cos(angles[i] + theta)
            ends[i, 1] = row + way * math.sin(angles[i] + theta)
        away = read_distance(distance, ends)
        expected = trace_ranges(distance, occupied, column, row, angles + theta, resolution, reach)
        for i in range(len(angles)):
            if math.isnan(ranges[i]):
                continue
            if math.isinf(ranges[i]):
                out[m, 0 if expected[i] > SHORT_OF_REACH * reach else 2] += 1.0
            elif away[i] < near:
                slack = GRAZING_SLACK_M + GRAZING_SLACK_RATIO * ranges[i]
                out[m, 2 if expected[i] < ranges[i] - slack else 0] += 1.0
            else:
                slack = MIN_SLACK_M + SLACK_RATIO * ranges[i]
                out[m, 2 if expected[i] < ranges[i] - slack else 1] += 1.0
    return out
