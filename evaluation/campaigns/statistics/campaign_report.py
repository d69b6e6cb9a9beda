"""Results of a campaign."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handcart.evaluation.campaigns.data.trial import Trial

from .action_shares import ActionShare
from .intervals import median_interval, wilson
from .tally import OUTCOME_NAMES, WORST_TRIAL_COUNT, Blame, Tally


@dataclass(frozen=True)
class Spread:
    """Summary of a metric's distribution over the trials of a campaign that report this metric."""

    count: int
    least: float
    median: float
    most_95: float
    """Value that 95 % of the trials do not exceed."""
    most: float
    mean: float
    """Mean; the share of yes for yes-or-no metrics."""
    low: float | None
    """Lower end of the 95 % interval of the median, or of the share of yes; None with too few trials."""
    high: float | None
    """Upper end of that interval."""


@dataclass(frozen=True)
class CampaignReport:
    """Statistics of a campaign, such as success rate, outcomes, metrics and causes of failure."""

    trials: Sequence[Trial]
    """Trials in the order of their seeds."""
    holds: bool | None = None
    """Verdict on the claimed success rate; None: no claim, or undecided."""

    counted: Tally | None = None
    """Tally of the trials, if it has been counted already; None otherwise."""

    @cached_property
    def tally(self) -> Tally:
        """Counts of outcomes, and values of metrics, of all trials of the campaign, computed in one pass."""
        return Tally(self.trials) if self.counted is None else self.counted

    @property
    def successes(self) -> int:
        """Number of trials that reached the goal."""
        return self.tally.successes

    @property
    def wilson(self) -> tuple[float, float]:
        """95 % confidence interval of the success rate, by Wilson's score interval; (0, 1) without trials."""
        return wilson(self.successes, len(self.trials))

    @property
    def outcomes(self) -> Counter[str]:
        """Counts of outcomes with reasons; `#` replaces numbers in a reason; a Success has no reason."""
        return self.tally.outcomes

    @property
    def untrue(self) -> list[Trial]:
        """Trials with an outcome that the ground truth contradicts."""
        return [self.trials[at] for at in self.tally.untrue]

    @property
    def faulty(self) -> bool:
        """True if the ground truth contradicts an outcome, or handcart itself failed in a trial."""
        return bool(self.tally.untrue or self.tally.broken)

    @property
    def shares(self) -> list[ActionShare]:
        """Return the outcome counts of each action, in the order of first occurrence."""
        return [
            ActionShare(name, *(found[outcome_name] for outcome_name in OUTCOME_NAMES))
            for name, found in self.tally.actions.items()
        ]

    @property
    def blames(self) -> list[tuple[Blame, int]]:
        """Counts of Fails and GiveUps by primitive (kind of action) and cause, the most frequent first."""
        return sorted(self.tally.blames.items(), key=lambda item: (-item[1], item[0]))

    @property
    def median_run(self) -> Trial | None:
        """Successful trial with the median time; None without a Success."""
        at = self.tally.median_run
        return None if at is None else self.trials[at]

    def spreads(self) -> dict[str, Spread]:
        """Return count, quantiles and mean of each metric over the trials, by the metric's name.

        With them is the 95 % confidence interval of the median or, for a metric that is True or False, of the
        share of True.
        """
        return {name: self._spread(name) for name in self.tally.columns}

    def _spread(self, name: str) -> Spread:
        values = np.asarray(self.tally.columns[name])
        least, median, most_95, most = map(float, np.quantile(values, [0.0, 0.5, 0.95, 1.0]))
        count = len(values)
        bounds = wilson(int(values.sum()), count) if name in self.tally.yes_no else median_interval(values)
        return Spread(count, least, median, most_95, most, float(values.mean()), *(bounds or (None, None)))

    def worst(self, most: int = WORST_TRIAL_COUNT) -> list[Trial]:
        """Return at most `most` trials to look at first.

        First come trials with false outcomes, then trials without Success, then trials with Fails.
        """
        return [self.trials[-rank[-1]] for rank in self.tally.worst[:most]]
