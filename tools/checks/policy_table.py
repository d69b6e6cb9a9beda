"""The rule and the best policy side by side, as lines of `handcart check`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from handcart.networks.analysis.comparison import Comparison, Difference, PolicyFigures

EQUAL_S = 1e-6
"""Difference of prices, in [s], up to which policies count as equally good."""


def comparison_lines(found: Comparison, person_s: float) -> Iterator[str]:
    """Yield the table of both policies, and the decisions in which they differ."""
    yield f"policies side by side (price: time, and {person_s:g} s for each end short of the goal):"
    yield f"  {'policy':<18}{'P(goal)':>20}{'mean':>12}{'95 %':>12}{'price':>20}"
    yield from (f"  {_row(each)}" for each in (found.rule, found.best))
    if not found.differences:
        yield "  they decide alike wherever runs are likely to come"
        return
    yield "  where they differ (how often a run of the best policy comes there):"
    yield from (f"    {_difference(each, found)}" for each in found.differences)


def _row(figures: PolicyFigures) -> str:
    goal = _ranged(figures.goal, ".5f", 5e-6)
    price, mean = _ranged(figures.price_s, ".1f", 0.05), _ranged(figures.mean_s, ".1f", 0.05)
    return f"{figures.name:<18}{goal:>20}{f'{mean} s':>12}{_quantile(figures):>12}{f'{price} s':>20}"


def _quantile(figures: PolicyFigures) -> str:
    low, high = figures.time_95_s
    return f"{low:.1f} s" if low == high else f">= {low:.1f} s"


def _ranged(bounds: tuple[float, float], form: str, same: float) -> str:
    low, high = bounds
    return f"{low:{form}}" if math.isclose(low, high, abs_tol=same) else f"[{low:{form}}, {high:{form}}]"


def _difference(each: Difference, found: Comparison) -> str:
    after = f" after {each.fails}" if each.fails else ""
    return f"{each.situation}{after}: rule {each.rule}, {found.best.name} {each.best} ({each.share:.4f})"
