"""First action in which two runs of one task differ."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import zip_longest

from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial


@dataclass(frozen=True)
class Divergence:
    """First action, in the order of the runs, in which two runs differ by the action's name or its
    outcome.
    """

    number: int
    """Number of the action, from 1."""
    one: ActionEnd | None
    """The first run's action; None if that run has ended before."""
    other: ActionEnd | None

    def words(self, one: str, other: str) -> str:
        """Describe in which action two runs first differ, and how, with the names of the two runs."""
        return f"differs first in action {self.number}: {one} {_said(self.one)}; {other} {_said(self.other)}"

    @property
    def kind(self) -> str:
        """Return a text that names the two differing ends of actions, to group pairs of trials that differ
        alike.
        """
        return f"{_kind(self.one)} against {_kind(self.other)}"


def first_difference(one: Trial, other: Trial) -> Divergence | None:
    """Return the first action in which two trials differ by name, situations or outcome; None if all are
    equal.
    """
    pairs = zip_longest(one.actions, other.actions)
    for number, (mine, theirs) in enumerate(pairs, start=1):
        if mine is None or theirs is None or _identity(mine) != _identity(theirs):
            return Divergence(number, mine, theirs)
    return None


def _identity(end: ActionEnd) -> tuple[str, str, str, str]:
    return end.action, end.source, end.target, end.outcome


def _said(end: ActionEnd | None) -> str:
    return "has ended" if end is None else f"{_kind(end)}{': ' if end.reason else ''}{end.reason}"


def _kind(end: ActionEnd | None) -> str:
    return "the end" if end is None else f"{end.action} {end.outcome}"
