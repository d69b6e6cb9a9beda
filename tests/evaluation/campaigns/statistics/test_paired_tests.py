"""Exact values of tests on pairs of trials."""

from __future__ import annotations

import pytest

from handcart.evaluation.campaigns.statistics.paired_tests import mcnemar


@pytest.mark.parametrize(
    ("only_one", "only_other", "p"),
    [(0, 0, 1.0), (1, 0, 1.0), (4, 4, 1.0), (8, 0, 2.0 / 2**8), (0, 8, 2.0 / 2**8), (1, 9, 22.0 / 2**10)],
)
def test_mcnemar_gives_the_exact_two_sided_value(only_one: int, only_other: int, p: float) -> None:
    assert mcnemar(only_one, only_other) == pytest.approx(p)
