"""Comparison of two campaigns, paired by seed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.files.errors import InputError

from .divergence import Divergence, first_difference
from .paired_tests import (
    SIGNIFICANCE_LEVEL,
    e_value,
    holm,
    mcnemar,
    signed_rank,
    smallest_difference,
    weights_of,
)
from .tally import figures

SUCCESS_METRIC = "success"
MAX_EXAMPLES = 3


class NoPairs(InputError):
    """Error for two campaigns that cannot be compared because they have no seed in common."""

    def __init__(self) -> None:
        super().__init__("no seed is in both campaigns; needed: the same --first and --trials for both")


@dataclass(frozen=True)
class MetricChange:
    """Mean change of one metric from a campaign to another, over pairs of trials, and its p-value."""

    name: str
    pairs: int
    """Number of pairs in which both trials have the metric."""
    mean: float
    """Mean difference, the other campaign's value minus the first one's, in the metric's unit; for success,
    the difference of the rates, from -1 to 1.
    """
    p_value: float
    adjusted: float
    """p-value adjusted over all metrics by Holm's method."""

    @property
    def proven(self) -> bool:
        """True if the metric's mean change is significant: its adjusted p-value is at most
        `SIGNIFICANCE_LEVEL`.
        """
        return self.adjusted <= SIGNIFICANCE_LEVEL


@dataclass
class Parting:
    """Group of paired trials of two campaigns in which only one trial succeeded.

    The actions of all pairs in a group first differ in the same way.
    """

    times: int = 0
    seeds: list[int] = field(default_factory=list)
    example: Divergence | None = None


@dataclass(frozen=True)
class Comparison:
    """Comparison of the success rates and metrics of two campaigns, by pairs of trials with equal seeds."""

    pairs: int
    unpaired: int
    """Number of trials whose seed the other campaign lacks; they are excluded."""
    only_one: int
    """Number of pairs in which only the first campaign's trial succeeded."""
    only_other: int
    changes: tuple[MetricChange, ...]
    """Change of the success rate, then those of the metrics that differ in some pair."""
    e_value: float
    """e-value after all pairs."""
    sure_at: int | None
    """Number of pairs, in the order of their seeds, after which the e-value first showed a difference."""
    smallest: float | None
    """Smallest difference of the success rates that would have been found; None if none would have been."""
    partings: dict[str, Parting]
    """First differences of the pairs in which only one trial succeeded."""

    @property
    def success(self) -> MetricChange:
        """Change of the success rate from the first campaign to the other one."""
        return self.changes[0]

    @property
    def worse(self) -> bool:
        """True if the second campaign's success rate is lower than the first one's, and `success.proven`."""
        return self.success.proven and self.success.mean < 0.0


def compare(one: Sequence[Trial], other: Sequence[Trial]) -> Comparison:
    """Compare two campaigns, pair by pair of trials with equal seeds.

    Args:
        one: trials of the first campaign, in the order of their seeds.
        other: trials of the other campaign, in the order of their seeds.

    Raises:
        NoPairs: the campaigns have no seed in common.
    """
    count = Counter[str]()
    columns: dict[str, list[float]] = {}
    partings: dict[str, Parting] = {}
    sure_at = None
    for mine, theirs in _paired(one, other):
        count["pairs"] += 1
        before, after = figures(mine), figures(theirs)
        for name in before.keys() & after.keys():
            columns.setdefault(name, []).append(float(after[name]) - float(before[name]))
        if mine.success == theirs.success:
            continue
        count["one" if mine.success else "other"] += 1
        if sure_at is None and e_value(count["one"], count["other"]) >= 1.0 / SIGNIFICANCE_LEVEL:
            sure_at = count["pairs"]
        _part(partings, mine, theirs)
    if not count["pairs"]:
        raise NoPairs
    only_one, only_other, pairs = count["one"], count["other"], count["pairs"]
    return Comparison(
        pairs,
        len(one) + len(other) - 2 * pairs,
        only_one,
        only_other,
        _changes(only_one, only_other, pairs, columns),
        e_value(only_one, only_other),
        sure_at,
        smallest_difference(only_one, only_other, pairs),
        dict(sorted(partings.items(), key=lambda item: (-item[1].times, item[0]))),
    )


def _paired(one: Iterable[Trial], other: Iterable[Trial]) -> Iterable[tuple[Trial, Trial]]:
    mine, theirs = iter(one), iter(other)
    left, right = next(mine, None), next(theirs, None)
    while left is not None and right is not None:
        if left.seed == right.seed:
            yield left, right
        behind = left.seed <= right.seed, right.seed <= left.seed
        left = next(mine, None) if behind[0] else left
        right = next(theirs, None) if behind[1] else right


def _part(partings: dict[str, Parting], mine: Trial, theirs: Trial) -> None:
    found = first_difference(mine, theirs)
    parting = partings.setdefault("the same actions" if found is None else found.kind, Parting(example=found))
    parting.times += 1
    if len(parting.seeds) < MAX_EXAMPLES:
        parting.seeds.append(mine.seed)


def _changes(
    only_one: int, only_other: int, pairs: int, columns: dict[str, list[float]]
) -> tuple[MetricChange, ...]:
    """Return the changes of all metrics that differ in some pair; equal metrics are not tested."""
    differences = {name: np.asarray(columns[name]) for name in sorted(columns)}
    looked = {name: difference for name, difference in differences.items() if difference.any()}
    p_values = {SUCCESS_METRIC: mcnemar(only_one, only_other)}
    p_values |= {name: signed_rank(item) for name, item in looked.items()}
    adjusted = holm(p_values, weights_of(SUCCESS_METRIC, list(looked)))
    rate = (only_other - only_one) / pairs
    first = MetricChange(SUCCESS_METRIC, pairs, rate, p_values[SUCCESS_METRIC], adjusted[SUCCESS_METRIC])
    rest = (
        MetricChange(name, len(item), float(item.mean()), p_values[name], adjusted[name])
        for name, item in looked.items()
    )
    return first, *rest
