"""Tests of the sides of books seen past a held book, on painted strips."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.primitives.books.slot_edge import moved, side_near
from handcart.robotics.perception.books.spine_edges import Strips

M_PER_PX = 0.0003
LEFT, COLUMNS, ROWS = 0.09, 600, 50
SIDES = (0.070, 0.041, 0.020, -0.015, -0.047, -0.070)
GREYS = (90.0, 170.0, 60.0, 140.0, 80.0, 190.0, 110.0)  # left of, between, right of them
WITHIN = 0.012  # [m]


def strips(sides: tuple[float, ...], hidden: float = -1.0) -> Strips:
    """Spines that end at `sides`, with a dark seam between each two; nothing seen right of `hidden`."""
    y = LEFT - np.arange(COLUMNS) * M_PER_PX
    row = np.array(GREYS)[(y[:, None] < np.array(sides)).sum(axis=1)]
    row[(np.abs(y[:, None] - np.array(sides)) < 0.0005).any(axis=1)] = 20.0
    grey = row + np.random.default_rng(1).normal(0.0, 2.0, (ROWS, COLUMNS))
    grey[:, y < hidden] = np.nan
    return Strips(grey, np.linspace(0.15, 0.05, ROWS), LEFT, M_PER_PX, -1)


def shifted(by: float) -> tuple[float, ...]:
    return tuple(side + by for side in SIDES)


@pytest.mark.parametrize("by", [0.0, 0.003, -0.0071, 0.0094])
def test_how_far_a_row_is_beside_where_it_was(by: float) -> None:
    assert moved(strips(shifted(by)), SIDES, WITHIN) == pytest.approx(by, abs=0.0005)


def test_one_book_that_was_pushed_alone_changes_nothing() -> None:
    pushed = (*shifted(0.004)[:2], SIDES[2] + 0.009, *shifted(0.004)[3:])
    assert moved(strips(pushed), SIDES, WITHIN) == pytest.approx(0.004, abs=0.0005)


def test_what_the_held_book_hides_needn_t_agree() -> None:
    assert moved(strips(shifted(0.003), hidden=0.028), SIDES, WITHIN) == pytest.approx(0.003, abs=0.0005)


def test_another_row_is_no_shift_of_this_one() -> None:
    apart = (0.002, 0.002, -0.0035, 0.0037, -0.002, -0.0005)
    other = tuple(side + item for side, item in zip(SIDES, apart, strict=True))
    assert moved(strips(other), SIDES, 0.004) is None


def test_one_side_in_view_tells_nothing() -> None:
    assert moved(strips(SIDES, hidden=0.05), SIDES, WITHIN) is None


def test_a_side_is_where_its_edge_is_or_where_it_was_expected() -> None:
    assert side_near(strips(SIDES), SIDES[3] + 0.0007) == pytest.approx(SIDES[3], abs=0.0004)
    assert side_near(strips(SIDES), 0.003) == 0.003
