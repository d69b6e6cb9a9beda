"""A table in a scan: its distance and turn by its sides, its place along them by its ends."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.rectangle_scan import RectangleFit, fit_rectangle
from handcart.robotics.navigation.scans.start_search import ScanBeams
from handcart.robotics.numerics.arrays import FloatArray

SIZE = (0.6, 1.2)
EXPECTED = Pose2(0.85, 0.1, 0.05)
PRIOR = np.diag([0.05, 0.05, math.radians(4.0)]) ** 2
ANGLES = np.radians(np.linspace(-95.0, 95.0, 271))
Outline = Sequence[tuple[float, float]]


def corners(pose: Pose2, size: tuple[float, float] = SIZE) -> Outline:
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(size) / 2
    return [(float(x), float(y)) for x, y in pose.apply(half)]


def ranges_to(outlines: Sequence[Outline], origin: FloatArray, angles: FloatArray) -> FloatArray:
    """Intersect each beam with each edge; independent of the slab method under test."""
    result = np.full(len(angles), 4.0)
    for outline in outlines:
        for start, end in zip(outline, (*outline[1:], outline[0]), strict=True):
            edge, off = np.subtract(end, start), np.subtract(start, origin)
            for i, angle in enumerate(angles.tolist()):
                ray = np.array([math.cos(angle), math.sin(angle)])
                across = ray[0] * edge[1] - ray[1] * edge[0]
                if abs(across) < 1e-12:
                    continue
                away = (off[0] * edge[1] - off[1] * edge[0]) / across
                at = (off[0] * ray[1] - off[1] * ray[0]) / across
                if away > 0.0 and 0.0 <= at <= 1.0:
                    result[i] = min(result[i], away)
    return result


def scans_of(outlines: Sequence[Outline], seed: int = 0, angles: FloatArray = ANGLES) -> list[ScanBeams]:
    rng, origin = np.random.default_rng(seed), np.array([0.2, 0.0])
    true = ranges_to(outlines, origin, angles)
    return [ScanBeams(origin, angles, true + rng.normal(0.0, 0.01, len(true)), 10.0) for _ in range(10)]


def fit(scans: Sequence[ScanBeams], size: tuple[float, float] = SIZE) -> RectangleFit | None:
    return fit_rectangle(scans, size, EXPECTED, PRIOR)


@pytest.mark.parametrize(
    "moved", [Pose2(0.03, 0.0, 0.05), Pose2(-0.02, 0.03, -0.05), Pose2(0.02, -0.04, 0.0)]
)
def test_moved_table_is_found_within_what_is_claimed(moved: Pose2) -> None:
    true = EXPECTED.compose(moved)
    found = fit(scans_of([corners(true)]))
    assert found is not None
    off = np.array([found.pose.x - true.x, found.pose.y - true.y, found.pose.theta - true.theta])
    assert np.abs(off) == pytest.approx(0.0, abs=0.008)
    assert off @ np.linalg.solve(found.covariance, off) < 14.2  # 99.7 % of chi-square with 3
    assert math.sqrt(found.covariance[0, 0]) < 0.004
    assert math.sqrt(found.covariance[1, 1]) < 0.008


def test_front_without_ends_leaves_its_place_along_it_open() -> None:
    true = EXPECTED.compose(Pose2(0.03, 0.04, 0.0))
    long, middle = (0.6, 9.0), ANGLES[np.abs(ANGLES) < 1.0]
    found = fit(scans_of([corners(true, long)], angles=middle), long)
    assert found is not None
    away = found.pose.relative_to(true)
    assert abs(away.x) < 0.004
    assert found.pose.relative_to(EXPECTED).y == pytest.approx(0.0, abs=0.01)  # as expected, and said so
    assert math.sqrt(found.covariance[1, 1]) > 0.03


def test_crate_before_a_third_of_it_does_not_pull_it() -> None:
    true = EXPECTED.compose(Pose2(0.02, 0.02, 0.03))
    found = fit(scans_of([corners(true), corners(Pose2(0.44, 0.3, 0.3), (0.1, 0.3))]))
    assert found is not None
    assert found.pose.distance(true) < 0.009
    assert found.pose.turn(true) < 0.01


def test_legs_or_nothing_are_no_table() -> None:
    legs = [
        corners(EXPECTED.compose(Pose2(x, y, 0.0)), (0.05, 0.05)) for x in (-0.25, 0.25) for y in (-0.5, 0.5)
    ]
    assert fit(scans_of(legs)) is None
    assert fit(scans_of([])) is None
    assert (
        fit(scans_of([corners(EXPECTED, (0.6, 0.8))])) is None
    )  # a narrower table: beams pass where it should be
    assert fit(scans_of([corners(EXPECTED.compose(Pose2(0.35, 0.0, 0.0)))])) is None


def test_blind_beams_and_scans_of_another_length_count_nothing() -> None:
    scans = scans_of([corners(EXPECTED)])
    scans[3].ranges[60:100] = np.nan
    short = ScanBeams(scans[0].origin, ANGLES[:50], np.ones(50), 10.0)
    found = fit([*scans, short])
    assert found is not None
    assert found.pose.distance(EXPECTED) < 0.008
    assert fit([ScanBeams(np.zeros(2), np.empty(0), np.empty(0), 10.0)]) is None
    assert fit([]) is None
