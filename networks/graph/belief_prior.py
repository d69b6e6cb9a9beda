"""Beliefs in the probabilities of a network's actions at the start of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple


class BeliefPrior(NamedTuple):
    """Beliefs in the actions' outcome probabilities at the start of a run, which learns them from outcomes.

    The probabilities in the task's file weigh as much as a number of observed attempts. Actions of the
    network that are copies of one action of the file share one belief.
    """

    attempts: float
    """Number of attempts that `p` of the file counts for."""
    entries: tuple[int, ...]
    """Number of the file's entry that each action is a copy of; -1 for a skip."""

    @classmethod
    def of(cls, attempts: float | None, entries: Sequence[int | None]) -> BeliefPrior | None:
        """Return the beliefs with which a run of a task starts.

        Args:
            attempts: number of observed attempts that have the same weight as the file's probabilities; None
                if a run does not learn probabilities.
            entries: number in the file of each action of the network; None if the action only skips an
                element of a repeat.

        Returns:
            The prior; None if `attempts` is None.
        """
        if attempts is None:
            return None
        return cls(attempts, tuple(-1 if entry is None else entry for entry in entries))

    @classmethod
    def read(cls, fields: Mapping[str, Any]) -> BeliefPrior | None:
        """Return the beliefs in the actions' outcome probabilities at the start of a run, from its journal's
        header.

        The result is None if the header contains none.
        """
        kept = fields.get("belief")
        return None if kept is None else cls(float(kept["attempts"]), tuple(map(int, kept["entries"])))


class Judged(NamedTuple):
    """Choice between the rule and the policy of the task's file for one plan, made by the present beliefs.

    The rule takes the cheapest route. Outcome probabilities are drawn from the beliefs many times, and the
    costs of both policies are compared in each draw.
    """

    follows: str
    """Policy that the plan follows: `rule`, or that of the file."""
    better: float
    """Share of draws in which the file's policy costs less than the rule."""
    saved_s: float
    """Cost that the file's policy saves in the mean of the draws, in [s]."""
    beliefs: tuple[tuple[int, float, float], ...]
    """Number of each entry whose belief differs from the prior, and its weights a, b of Success and Fail."""

    def fields(self) -> dict[str, Any]:
        """Return this choice of the cheapest route or the file's policy as fields of a journal's record."""
        beliefs = [[entry, round(a, 6), round(b, 6)] for entry, a, b in self.beliefs]
        kept = {"follows": self.follows, "better": round(self.better, 6), "saved_s": round(self.saved_s, 6)}
        return {**kept, "beliefs": beliefs}

    @classmethod
    def read(cls, fields: Mapping[str, Any]) -> Judged:
        """Restore the choice between the cheapest route and the policy of the task's file from a journal's
        record.
        """
        beliefs = tuple((int(entry), float(a), float(b)) for entry, a, b in fields["beliefs"])
        return cls(str(fields["follows"]), float(fields["better"]), float(fields["saved_s"]), beliefs)
