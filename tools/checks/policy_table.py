"""The rule and the best policy side by side, as lines of `handcart check`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from handcart.networks.deciding.comparison import PolicyComparison, PolicyDifference
    from handcart.networks.deciding.run_figures import PolicyFigures

MAX_PERSON_S = 1e6
"""Largest price of a person that a task's file accepts, in [s]."""
COPY_NUMBER = re.compile(r"\[\d+\]")
"""Part of a situation's name, such as `[2]`, that numbers the copies that a `repeat` makes of it."""
FOUND_SHARE = 1e-3
"""Relative difference of the best price and its lower bound from which the bound is printed."""


def comparison_lines(found: PolicyComparison, person_s: float) -> Iterator[str]:
    """Yield lines of text: a table of two policies, and the decisions in which the policies differ.

    One policy is the rule, which always starts the first action of the cheapest plan to the goal; the other
    is the best policy that was found.

    Args:
        found: comparison of the rule and the best policy, with their prices.
        person_s: price, in [s], of a run that ends before the goal, because a person has to come.
    """
    yield f"policies side by side (price: time, and {person_s:g} s for each end short of the goal):"
    yield f"  {'policy':<18}{'P(goal)':>20}{'mean':>12}{'95 %':>12}{'price':>20}"
    yield from (f"  {_row(item)}" for item in (found.rule, found.best))
    if found.follows_rule:
        yield "  no better policy than the rule was found within the budget: the rule is followed"
        return
    if not found.is_probability and found.best.price_s[1] - found.low_s > FOUND_SHARE * found.low_s:
        yield f"  no policy costs less than {found.low_s:.1f} s; the search ended at its budget"
    if found.call_limit_s is not None:
        yield f"  {_call(found, person_s)}"
    if not found.differences:
        yield "  they decide alike wherever runs are likely to come"
        return
    yield "  where they differ (how often a run of the best policy comes there):"
    yield from (f"    {line}" for line in _differences(found))


def _call(found: PolicyComparison, person_s: float) -> str:
    """Return why a person is called at the start, and what changes it."""
    assert found.call_limit_s is not None
    cost = f"a person ({person_s:g} s) costs less than the task by any policy"
    if found.call_limit_s > MAX_PERSON_S:
        return f"{found.best.name} calls a person at the start: {cost}, and the rule hardly reaches the goal"
    limit = f"with person_s above {found.call_limit_s:.0f}, or policy: goal_probability, it is tried"
    return f"{found.best.name} calls a person at the start: {cost}; {limit}"


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


def _differences(found: PolicyComparison) -> Iterator[str]:
    """Yield a line for each decision in which the policies differ; copies that a `repeat` makes share one
    line.
    """
    alike: dict[str, list[PolicyDifference]] = {}
    for difference in found.differences:
        words = f"{difference.situation} {difference.fails} {difference.rule} {difference.best}"
        alike.setdefault(COPY_NUMBER.sub("[]", words), []).append(difference)
    for first, *others in alike.values():
        after = f" after {first.fails}" if first.fails else ""
        like = f", {len(others)} more like it" if others else ""
        choice = f"rule {first.rule}, {found.best.name} {first.best}"
        yield f"{first.situation}{after}: {choice} ({first.share:.4f}{like})"
