"""Rare outcome of a run, and the importance by which trials approach it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast, get_args

from handcart.files.errors import InputError
from handcart.files.suggest import suggest
from handcart.networks.events.run_end import RunOutcome

Importance = Literal["fails", "attempts"]
"""Measure of how near a run is to the rare outcome: the number of all Fails so far, or the largest number
of attempts that one action has used up.
"""
RARE_OUTCOMES: tuple[RunOutcome, ...] = ("Success", "Fail", "GiveUp")
MAX_RUNS = 1_000_000


class NoRareEvent(InputError):
    """Error for an estimate of a rare event with invalid settings; raised before any run."""


@dataclass(frozen=True)
class RareEvent:
    """Rare outcome of a run, and settings of the estimate of its probability by multilevel splitting.

    Multilevel splitting simulates a population of runs and repeatedly copies those nearest to the outcome.
    """

    outcome: RunOutcome
    importance: Importance = "fails"
    runs: int = 100
    """Number of runs of a population at each of its levels."""

    @classmethod
    def of(cls, outcome: str, importance: str | None = None, runs: int | None = None) -> RareEvent:
        """Return the rare outcome whose probability is estimated, and the settings, from command-line values.

        `importance` is the measure of nearness to the outcome; `runs` is the number of runs at each level. A
        value of None selects the default.

        Raises:
            NoRareEvent: a value is invalid.
        """
        importance, runs = importance or cls.importance, cls.runs if runs is None else runs
        for given, known, option in (
            (outcome, RARE_OUTCOMES, "--rare"),
            (importance, get_args(Importance), "--importance"),
        ):
            if given not in known:
                raise NoRareEvent(f"{option} {given}: no such one{suggest(given, known)}")
        if not 2 <= runs <= MAX_RUNS:
            raise NoRareEvent(f"--population {runs}; allowed: 2 to {MAX_RUNS} runs")
        return cls(cast(RunOutcome, outcome), cast(Importance, importance), runs)
