"""The rise of a shifted scan's cost: the compiled loop against plain numpy, and on a map of one row."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.scans.likelihood_field import (
    LikelihoodField,
    beam_sectors,
    read_field,
)
from handcart.robotics.navigation.scans.scan_evidence import _weakest_axis, rises
from handcart.robotics.navigation.scans.scan_matching import _inverse

SCALE_M, STEPS_M = 0.05, np.array([0.13, 0.26])


def cost(distances: np.ndarray) -> np.ndarray:
    squares = np.minimum(distances, 1e3 * SCALE_M) ** 2
    return np.asarray(squares * SCALE_M**2 / (SCALE_M**2 + squares))


def read(field: LikelihoodField, points: np.ndarray, sectors: np.ndarray) -> np.ndarray:
    at = (points - (field.map.origin_x, field.map.origin_y)) / field.map.resolution - 0.5
    return np.asarray(read_field(field.facing, field.map.occupied, at, sectors)[:, 0]) * field.map.resolution


@pytest.mark.parametrize("every", [1, 3])
def test_a_moved_scan_costs_what_numpy_says(every: int) -> None:
    """Some of its points leave the map as they are shifted."""
    rng = np.random.default_rng(4)
    grid = from_boxes([(2.0, 0.1, 0.2, 4.0, 0.2), (1.0, 2.0, 0.7, 0.5, 0.3)], 0.05, (0.0, 0.0), (4.0, 3.0))
    field = LikelihoodField(grid)
    points = rng.uniform((0.05, 0.05), (3.9, 2.9), (200, 2))
    middle = np.array([2.0, 1.5])
    reading, sectors = field.reading(points, (2.0, 1.5)), beam_sectors(points, (2.0, 1.5), len(field.facing))
    motions = np.array([[1.0, 0.0, 0.2], [0.6, 0.8, -0.1], [0.0, 0.0, -0.7]])
    where = (grid.origin_x, grid.origin_y), grid.resolution, field.facing, sectors
    slopes = np.ascontiguousarray(reading.slopes)
    scan = np.ascontiguousarray(points), np.ascontiguousarray(reading.distances), slopes
    found = rises(motions, STEPS_M, every, *where, *scan, middle, SCALE_M)
    some, then = points[::every], reading.distances[::every]
    for (x, y, turn), of_motion in zip(motions.tolist(), found, strict=True):
        moved = np.array([x, y]) + turn * np.column_stack([some[:, 1] - middle[1], middle[0] - some[:, 0]])
        for step, (seen, claimed, one) in zip(STEPS_M, of_motion, strict=True):
            shifted = [cost(read(field, some + way * moved, sectors[::every])) for way in (step, -step)]
            assert seen == pytest.approx(float((shifted[0] + shifted[1] - 2.0 * cost(then)).sum()), rel=1e-6)
            along = np.abs(np.sum(slopes[::every] * moved, axis=1))
            assert claimed == pytest.approx(float(2.0 * cost(step * along).sum()), rel=1e-9)
            assert one == pytest.approx(2.0 * float(cost(step)), rel=1e-9)


def test_a_map_of_one_row_reads_as_beyond_it() -> None:
    points, distance = np.array([[0.1, 0.02]]), np.zeros((1, 1, 40), np.uint16)
    sectors = np.zeros(1, np.int32)
    zero = np.zeros(1), np.empty((0, 2)), np.zeros(2)
    found = rises(
        np.array([[1.0, 0.0, 0.0]]), STEPS_M, 1, (0.0, 0.0), 0.05, distance, sectors, points, *zero, SCALE_M
    )
    assert found[0, :, 0] == pytest.approx(2.0 * SCALE_M**2, rel=1e-5)


def test_the_weakest_axis_is_the_first_eigenvector() -> None:
    rng = np.random.default_rng(5)
    for factor in rng.normal(size=(50, 2, 2)):
        matrix = factor @ factor.T
        assert abs(_weakest_axis(matrix) @ np.linalg.eigh(matrix)[1][:, 0]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("least", [1e-8, 1e-2, -1e-3])
def test_the_inverse_by_hand_is_that_of_lapack(least: float) -> None:
    """Also for a matrix that is almost singular, or has a negative variance."""
    rng = np.random.default_rng(6)
    for item in rng.normal(size=(50, 3, 3)):
        axes = np.linalg.qr(item)[0]
        matrix = axes @ np.diag([least, 0.5, 3.0]) @ axes.T
        expected = np.linalg.inv(0.5 * (matrix + matrix.T) + 1e-12 * np.eye(3))
        np.testing.assert_allclose(_inverse(0.5 * (matrix + matrix.T)), expected, rtol=1e-5, atol=1e-6)
