"""Exact tests of paired campaigns, and their power."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.optimize import brentq
from scipy.special import betaln
from scipy.stats import binom, binomtest, wilcoxon

from handcart.robotics.numerics.arrays import FloatArray

SIGNIFICANCE_LEVEL = 0.05
TEST_POWER = 0.8
FIRST_SHARE = 0.9
"""Share of `SIGNIFICANCE_LEVEL` reserved for the success rate; the other metrics share the rest."""


def mcnemar(only_one: int, only_other: int) -> float:
    """Return the exact, two-sided p-value of the hypothesis that two success rates are equal.

    McNemar (1947): under the hypothesis, a pair with one Success favours either campaign equally often.

    Args:
        only_one: number of pairs in which only the first campaign succeeded.
        only_other: number of pairs in which only the other campaign succeeded.
    """
    count = only_one + only_other
    return 1.0 if not count else float(binomtest(only_one, count, 0.5).pvalue)


def signed_rank(differences: FloatArray) -> float:
    """Return the two-sided p-value that differences (n,) of a metric are symmetric about 0, by Wilcoxon's
    signed-rank test (1945).

    Zero differences are dropped; the p-value is 1 if no others are left.
    """
    there = differences[differences != 0.0]
    if not len(there):
        return 1.0
    exact = len(there) <= 50 and len(np.unique(np.abs(there))) == len(there)
    return float(wilcoxon(there, method="exact" if exact else "approx", correction=not exact).pvalue)


def holm(p_values: Mapping[str, float], weights: Mapping[str, float]) -> dict[str, float]:
    """Return p-values adjusted for multiple tests, by Holm's weighted step-down method (1979, section 4).

    If two campaigns do not differ, an adjusted p-value at or below `SIGNIFICANCE_LEVEL` occurs with a
    probability of at most `SIGNIFICANCE_LEVEL`.

    Args:
        p_values: p-value of each test, by name.
        weights: positive weight of each test, by the same names; a larger one makes significance easier.
    """
    left, out, least = dict(p_values), {}, 0.0
    while left:
        name = min(left, key=lambda item: left[item] / weights[item])
        total = sum(weights[item] for item in left)
        least = max(least, min(1.0, left.pop(name) * total / weights[name]))
        out[name] = least
    return out


def weights_of(first: str, others: list[str]) -> dict[str, float]:
    """Return the weight of each statistical test in a family of tests, by its name.

    The first test has the weight `FIRST_SHARE`; the others share the rest equally.
    """
    rest = (1.0 - FIRST_SHARE) / max(1, len(others))
    return {first: FIRST_SHARE, **dict.fromkeys(others, rest)}


def e_value(only_one: int, only_other: int) -> float:
    """Return the e-value against equal success rates of two campaigns; large values show a difference.

    The value may be computed after each pair: if the rates are equal, the probability that it ever reaches
    1 / alpha is at most alpha (Ville 1939). It is the likelihood ratio of a uniform mixture of all rates
    (Robbins 1970) to equal rates.

    Args:
        only_one: number of pairs in which only the first campaign succeeded.
        only_other: number of pairs in which only the other campaign succeeded.
    """
    count = only_one + only_other
    log = float(betaln(1 + only_one, 1 + only_other)) + count * math.log(2.0)
    return math.exp(min(log, 700.0))


def mcnemar_power(difference: float, lost: float, pairs: int, alpha: float = SIGNIFICANCE_LEVEL) -> float:
    """Return the probability that the exact McNemar test finds a difference of success rates.

    Args:
        difference: difference of the rates.
        lost: share of pairs in which only the worse campaign succeeds; the share in which only the better one
            succeeds is `lost + difference`.
        pairs: number of pairs.
        alpha: significance level of the test.
    """
    share = min(1.0, 2.0 * lost + difference)
    low, high = binom.ppf([1e-10, 1.0 - 1e-10], pairs, share)
    counts = np.arange(int(low), int(high) + 1)
    # The largest smaller count that is still significant; -1: none is.
    critical = binom.ppf(alpha / 2.0, counts, 0.5).astype(int)
    critical -= 2.0 * binom.cdf(critical, counts, 0.5) > alpha
    better = (lost + difference) / share if share else 0.5
    seen = binom.cdf(critical, counts, better) + binom.sf(counts - critical - 1, counts, better)
    seen[critical < 0] = 0.0
    return float(np.sum(binom.pmf(counts, pairs, share) * seen))


def smallest_difference(only_one: int, only_other: int, pairs: int) -> float | None:
    """Return the smallest difference of success rates that McNemar's test would find with the probability
    `TEST_POWER`.

    The share of pairs in which only the worse campaign succeeds is assumed to be that of the data. None if
    the number of pairs is too small to show any difference.

    Args:
        only_one: number of pairs in which only the first campaign succeeded.
        only_other: number of pairs in which only the other campaign succeeded.
        pairs: number of all pairs.
    """
    lost = min(only_one, only_other) / pairs
    most = 1.0 - 2.0 * lost
    if most <= 0.0 or mcnemar_power(most, lost, pairs) < TEST_POWER:
        return None
    return float(brentq(lambda item: mcnemar_power(item, lost, pairs) - TEST_POWER, 0.0, most, xtol=1e-5))
