"""Beliefs in the probabilities of a network's actions at the start of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple


class BeliefPrior(NamedTuple):
    """Weight of the file's probabilities, and the actions that share a belief."""

    attempts: float
    """Number of attempts that `p` of the file counts for."""
    entries: tuple[int, ...]
    """Number of the file's entry that each action is a copy of; -1 for a skip."""

    @classmethod
    def of(cls, attempts: float | None, entries: Sequence[int | None]) -> BeliefPrior | None:
        """Return the prior of a task; None if its probabilities hold throughout."""
        if attempts is None:
            return None
        return cls(attempts, tuple(-1 if entry is None else entry for entry in entries))

    @classmethod
    def read(cls, fields: Mapping[str, Any]) -> BeliefPrior | None:
        """Return the prior in a journal's header; None without one."""
        kept = fields.get("belief")
        return None if kept is None else cls(float(kept["attempts"]), tuple(map(int, kept["entries"])))


class Judged(NamedTuple):
    """Choice between two policies for one plan, by the beliefs in the actions' probabilities at that time."""

    follows: str
    """Policy that the plan follows: `rule`, or that of the file."""
    better: float
    """Share of draws in which the file's policy costs less than the rule."""
    saved_s: float
    """Cost that the file's policy saves in the mean of the draws, in [s]."""
    beliefs: tuple[tuple[int, float, float], ...]
    """Number of each entry whose belief differs from the prior, and its weights a, b of Success and Fail."""

    def fields(self) -> dict[str, Any]:
        """Return the judgement as fields of a journal's record."""
        beliefs = [[entry, round(a, 6), round(b, 6)] for entry, a, b in self.beliefs]
        kept = {"follows": self.follows, "better": round(self.better, 6), "saved_s": round(self.saved_s, 6)}
        return {**kept, "beliefs": beliefs}

    @classmethod
    def read(cls, fields: Mapping[str, Any]) -> Judged:
        """Return the judgement in a journal."""
        beliefs = tuple((int(entry), float(a), float(b)) for entry, a, b in fields["beliefs"])
        return cls(str(fields["follows"]), float(fields["better"]), float(fields["saved_s"]), beliefs)
