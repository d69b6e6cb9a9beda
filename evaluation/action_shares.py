"""How often each action succeeded, failed and gave up: what a task's `p` and `p_give_up` can come from."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scipy.stats import binomtest

from networks.past_run import read_run

OUTCOMES = ("Success", "Fail", "GiveUp")


@dataclass(frozen=True)
class ActionShare:
    """How attempts of one action of a task ended; in a repeat, those of all elements together."""

    action: str
    """As in the file: `MOVE_TO (in_hand to at_shelf)`."""
    success: int
    fail: int
    give_up: int

    @property
    def attempts(self) -> int:
        """How many there were; those that were broken off are left out."""
        return self.success + self.fail + self.give_up

    @property
    def p(self) -> float:
        """Share of Success."""
        return self.success / self.attempts

    @property
    def wilson(self) -> tuple[float, float]:
        """95 % interval of the probability of Success, by Wilson."""
        interval = binomtest(self.success, self.attempts).proportion_ci(method="wilson")
        return float(interval.low), float(interval.high)


def action_shares(folders: Iterable[Path]) -> list[ActionShare]:
    """The shares of all actions that were started, in the order in which they first were.

    Args:
        folders: of runs of one task.

    Raises:
        NoRun, JournalError: a folder's journal can't be read.
    """
    counts: dict[str, Counter[str]] = {}
    for folder in folders:
        for each in read_run(folder).actions:
            if each.outcome in OUTCOMES:
                words = f"{each.do} ({_plain(each.source)} to {_plain(each.target)})"
                counts.setdefault(words, Counter())[each.outcome] += 1
    return [ActionShare(words, *(found[name] for name in OUTCOMES)) for words, found in counts.items()]


def _plain(situation: str) -> str:
    """A situation without the number of its copy."""
    return re.sub(r"\[\d+\]$", "", situation)
