"""Intervals and the exact test, against a library's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from handcart.evaluation.campaigns.statistics.exact_value import compare_share
from handcart.evaluation.campaigns.statistics.intervals import median_interval, wilson

COUNTS = (1, 2, 5, 6, 7, 20, 59, 100, 1000, 12345)


@pytest.mark.parametrize("count", COUNTS)
def test_shares_are_bounded_as_by_wilson(count: int) -> None:
    for successes in {0, 1, count // 3, count - 1, count}:
        interval = binomtest(successes, count).proportion_ci(0.95, method="wilson")
        assert wilson(successes, count) == pytest.approx((interval.low, interval.high), abs=1e-12)
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("p", [0.0, 1e-4, 0.3, 0.5, 0.977, 1.0])
def test_a_share_is_held_against_a_value_exactly(count: int, p: float) -> None:
    for successes in {0, 1, count // 3, count - 1, count}:
        exact = binomtest(successes, count, p).pvalue
        assert compare_share(p, successes, count).p_value == pytest.approx(exact, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("count", range(40))
def test_a_median_lies_between_two_of_the_values(count: int) -> None:
    values = np.random.default_rng(count).permutation(count).astype(np.float64)
    rank = int(binom.ppf(0.025, count, 0.5)) if count else 0
    assert median_interval(values) == ((rank - 1.0, count - rank + 0.0) if rank > 0 else None)
