"""Strips are shifted against each other so that edges are upright."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.books.spine_edges import Strips, upright

HEIGHTS = np.linspace(0.2, 0.0, 20)


def leaning(tilt: float, rows: int = 20, width: int = 160) -> Strips:
    """Three spines whose edges lean."""
    z, columns = HEIGHTS[:rows], np.arange(width)
    shifts = tilt * (z - z.mean()) / 0.0005
    grey = np.array(
        [
            np.interp(columns - shift, (0, 40, 61, 90, 111, 159), (90, 90, 150, 150, 60, 60))
            for shift in shifts
        ]
    )
    return Strips(grey, z, 0.1, 0.0005, -1)


def spread(grey: FloatArray) -> float:
    """Return the largest difference of the strips."""
    return float(np.abs(grey - grey.mean(axis=0)).max())


@pytest.mark.parametrize("tilt", [-0.03, -0.01, 0.02])
def test_edges_that_lean_stand_upright_afterwards(tilt: float) -> None:
    before, after = (item.grey[:, 20:140] for item in (leaning(tilt), upright(leaning(tilt))))
    assert spread(after) < 0.3 * spread(before)


def test_rows_are_interpolated_between_columns_and_nan_outside() -> None:
    strips = leaning(0.02)
    strips.grey[3, 70:80] = np.nan
    shown = upright(strips)
    columns = np.arange(160)
    tilts = np.linspace(-0.05, 0.05, 41)
    candidates = [
        np.array(
            [
                np.interp(columns + tilt * (z - HEIGHTS.mean()) / 0.0005, columns, row, 0, 0)
                for row, z in zip(strips.grey, HEIGHTS, strict=True)
            ]
        )
        for tilt in tilts
    ]
    assert any(np.allclose(shown.grey, candidate, equal_nan=True, atol=1e-9) for candidate in candidates)
    assert np.isnan(shown.grey[3]).sum() >= 9
