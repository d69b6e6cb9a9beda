"""Claim about the success rate, decided as soon as there are enough trials."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from scipy.special import betaln

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.files.errors import InputError

MAX_ERROR_PROBABILITY = 0.05
"""Maximum probability of a wrong verdict, however often the verdict is asked for."""
_FORM = re.compile(r"\s*p\s*(>|<)\s*(0?\.\d+)\s*")


class NoClaim(InputError):
    """Error for a text that is not a claim about the success rate, such as `p > 0.95`."""

    def __init__(self, words: str) -> None:
        super().__init__(f'--until "{words}": no claim; allowed: "p > 0.95" or "p < 0.5", between 0 and 1')


@dataclass(frozen=True)
class RateClaim:
    """Claim that the success rate of a campaign is above, or below, a limit."""

    above: bool
    limit: float

    @classmethod
    def of(cls, words: str) -> RateClaim:
        """Parse a claim such as `p > 0.95`.

        Raises:
            NoClaim: the text is not a claim.
        """
        found = _FORM.fullmatch(words)
        if found is None or not 0.0 < float(found[2]) < 1.0:
            raise NoClaim(words)
        return cls(found[1] == ">", float(found[2]))

    def __str__(self) -> str:
        return f"p {'>' if self.above else '<'} {self.limit:g}"

    def verdict(self, successes: int, count: int) -> bool | None:
        """Return whether the claim holds, or None while undecided.

        The claim is decided once its limit is outside a confidence sequence (Robbins 1970): success rates are
        excluded that are less likely by a factor of `MAX_ERROR_PROBABILITY` than a uniform mixture of all
        rates. A confidence sequence remains valid if the verdict is computed after each trial.
        """
        failures = count - successes
        bet = float(betaln(1 + successes, 1 + failures))
        bet -= successes * math.log(self.limit) + failures * math.log1p(-self.limit)
        if bet < -math.log(MAX_ERROR_PROBABILITY):
            return None
        return (successes > count * self.limit) is self.above


class Settling:
    """State of the test of a claim about the success rate, while parallel trials end in any order.

    Trials are counted in the order of their seeds, with a verdict on the claim after each, so that the
    counted trials do not depend on how long trials take.
    """

    def __init__(self, claim: RateClaim, seeds: Sequence[int]) -> None:
        """Begin without any trial; trials will count in the order of `seeds`."""
        self.claim, self._seeds = claim, seeds
        self.count = self.successes = 0
        """Number of counted trials."""
        self.verdict: bool | None = None
        self._waiting: dict[int, bool] = {}

    def hear(self, trial: Trial) -> bool:
        """Add a trial that has ended, and return whether the claim is confirmed or refuted now.

        Trials may be added in any order. A trial counts once all trials before it in the order of the seeds
        have been added.
        """
        self._waiting[trial.seed] = trial.success
        while self.verdict is None and self.count < len(self._seeds):
            success = self._waiting.pop(self._seeds[self.count], None)
            if success is None:
                break
            self.count += 1
            self.successes += success
            self.verdict = self.claim.verdict(self.successes, self.count)
        return self.verdict is not None

    @classmethod
    def heard(cls, words: str | None, seeds: Sequence[int], trials: Iterable[Trial]) -> Settling | None:
        """Return the state of a claim about the success rate after the trials that have ended; None without a
        claim.

        Args:
            words: the claim, such as `p > 0.95`; None without a claim.
            seeds: seeds of all trials of the campaign, in the order in which they count.
            trials: trials that have ended.

        Raises:
            NoClaim: the text is not a claim.
        """
        if words is None:
            return None
        settling = cls(RateClaim.of(words), seeds)
        any(settling.hear(trial) for trial in trials)
        return settling

    def words(self) -> str:
        """Return as text whether the claim about the success rate holds, and how many trials decided it."""
        if self.verdict is None:
            return f"{self.claim}: {self.count} trials are not enough to be sure"
        return f"{self.claim}: {'yes' if self.verdict else 'no'}, sure after {self.count} trials"
