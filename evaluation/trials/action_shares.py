"""How often each action succeeded, failed and gave up: what a task's `p` and `p_give_up` can come from."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scipy.stats import binomtest

from handcart.networks.journal.past_run import read_run

OUTCOMES = ("Success", "Fail", "GiveUp")
_Key = tuple[str, str, str]


@dataclass(frozen=True)
class ActionShare:
    """How attempts of one action of a task ended; in a repeat, those of all elements together."""

    action: str
    """As in the file: `MOVE_TO (loaded to there)`."""
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
    counts: dict[_Key, Counter[str]] = {}
    reached: dict[_Key, str] = {}
    for folder in folders:
        run = read_run(folder)
        drawn = [] if run.network is None else run.network.network.actions
        reached |= {
            _key(each.do, each.source, each.target): _split(each.target)[0] for each in drawn if each.binding
        }
        for each in run.actions:
            if each.outcome in OUTCOMES:
                key = _key(each.do, each.source, each.target)
                reached.setdefault(key, _split(each.target)[0])
                counts.setdefault(key, Counter())[each.outcome] += 1
    return [
        ActionShare(f"{key[0]} ({key[1]} to {reached[key]})", *(found[name] for name in OUTCOMES))
        for key, found in counts.items()
    ]


def _key(do: str, source: str, target: str) -> _Key:
    """What all copies of an action share. The last one of an element leads to the next element's start, and
    that of the last element out of the repeat.
    """
    (start, copy), (end, other) = _split(source), _split(target)
    return do, start, "" if copy != other else end


def _split(situation: str) -> tuple[str, str]:
    """A situation and the number of its copy, if any."""
    found = re.fullmatch(r"(.*)\[(\d+)\]", situation)
    return (found[1], found[2]) if found else (situation, "")
