"""An end of a run that is seldom seen, and how trials come nearer to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast, get_args

from handcart.files.errors import InputError
from handcart.files.suggest import suggest
from handcart.networks.coordination.run_end import RunOutcome

Importance = Literal["fails", "attempts"]
"""What is counted, to tell how near a run has come: all Fails by now; or the attempts that were used up of
the action of which most were."""
OUTCOMES: tuple[RunOutcome, ...] = ("Success", "Fail", "GiveUp")
MOST_RUNS = 1_000_000


class NoRareEvent(InputError):
    """What is asked for is no end of a run; nothing has moved."""


@dataclass(frozen=True)
class RareEvent:
    """How often runs end like this is asked for."""

    outcome: RunOutcome
    importance: Importance = "fails"
    runs: int = 100
    """Of a population, at each of its levels."""

    @classmethod
    def of(cls, outcome: str, importance: str | None = None, runs: int | None = None) -> RareEvent:
        """As words say it; raises `NoRareEvent`."""
        importance, runs = importance or cls.importance, cls.runs if runs is None else runs
        for given, known, option in (
            (outcome, OUTCOMES, "--rare"),
            (importance, get_args(Importance), "--importance"),
        ):
            if given not in known:
                raise NoRareEvent(f"{option} {given}: no such one{suggest(given, known)}")
        if not 2 <= runs <= MOST_RUNS:
            raise NoRareEvent(f"--population {runs}; allowed: 2 to {MOST_RUNS} runs")
        return cls(cast(RunOutcome, outcome), cast(Importance, importance), runs)
