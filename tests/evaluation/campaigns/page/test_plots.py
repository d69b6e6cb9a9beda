"""Positions in the small plots of a campaign's page."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from handcart.evaluation.campaigns.page.plots import HEIGHT, WIDTH, PlotAxis, histogram


def test_round_numbers_stand_on_an_axis() -> None:
    assert [words for _, words in PlotAxis(0.0, 1.0, 100.0).ticks()] == ["0", "0.5", "1"]
    (at, words), *_ = PlotAxis(2.63, 2.91, 280.0).ticks()
    assert at == pytest.approx(70.0)
    assert words == "2.7"
    assert [words for _, words in PlotAxis(-0.5, 1.5, 100.0, whole=True).ticks()] == ["0", "1"]
    assert PlotAxis(7.0, 7.0, 100.0).ticks() == [(50.0, "7")]


@given(some.floats(-1e12, 1e12), some.floats(1e-9, 1e12))
def test_an_axis_has_a_few_round_numbers_all_of_them_on_it(least: float, span: float) -> None:
    if not least + span > least:
        return
    ticks = PlotAxis(least, least + span, 100.0).ticks()
    assert len(ticks) <= 5
    assert all(-1e-3 <= at <= 100.001 for at, _ in ticks)


def test_histogram_counts_each_trial_once_and_marks_failed_ones() -> None:
    values = np.array([1.0, 2.0, 2.0, 3.0, math.nan, 3.0])
    success = np.array([True, True, False, True, True, False])
    found = histogram(values, success, limit=6.0)
    assert [(bar.reached, bar.others) for bar in found.bars] == [
        (HEIGHT / 2, 0.0),
        (HEIGHT / 2, HEIGHT / 2),
        (HEIGHT / 2, HEIGHT / 2),
    ]
    assert (found.highest, found.limit) == (2, WIDTH)
    assert found.median == pytest.approx(WIDTH * 1.5 / 5.5)


def test_histogram_axis_holds_all_bars_and_the_limit() -> None:
    values, success = np.array([1.0, 1.5, 2.0, 3.0]), np.ones(4, bool)
    for limit in (None, 0.2, 2.0, 4.0):
        found = histogram(values, success, limit)
        assert found.bars[0].x == pytest.approx(0.0 if limit != 0.2 else found.bars[0].x)
        assert min(found.bars[0].x, found.limit or 0.0) == pytest.approx(0.0)
        last = found.bars[-1]
        assert max(last.x + last.width, found.limit or 0.0) == pytest.approx(WIDTH)


@given(some.lists(some.floats(-1e9, 1e9), min_size=1, max_size=60))
def test_whatever_the_values_bars_lie_side_by_side(values: list[float]) -> None:
    found = histogram(np.array(values), np.ones(len(values), bool))
    assert len(found.bars) <= 30
    assert max(bar.reached for bar in found.bars) == pytest.approx(HEIGHT)
    for left, right in zip(found.bars, found.bars[1:], strict=False):
        assert right.x == pytest.approx(left.x + left.width, abs=1e-3)
