"""Intervals by their formulas are those of scipy.stats."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from handcart.evaluation.campaign_report.intervals import LEVEL, median_interval, wilson


@pytest.mark.parametrize("count", [1, 2, 7, 40, 1000, 99_999])
def test_wilson(count: int) -> None:
    for successes in sorted({0, 1, count // 3, count // 2, count - 1, count}):
        expected = binomtest(successes, count).proportion_ci(LEVEL, method="wilson")
        assert wilson(successes, count) == pytest.approx((expected.low, expected.high), rel=1e-13, abs=1e-15)


def test_of_no_trials_it_is_everything() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize("count", [0, 1, 5, 6, 8, 9, 100, 1001])
def test_the_medians_ranks(count: int) -> None:
    rank = int(binom.ppf((1.0 - LEVEL) / 2.0, count, 0.5)) if count else 0
    values = np.random.default_rng(3).permutation(count).astype(float)
    assert median_interval(values) == (None if rank < 1 else (rank - 1.0, float(count - rank)))
