"""Trials that are judged, and those in which the machine itself was too slow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

LATE_LIMIT_S = 0.05
"""[s] by which no period of bench and program may be too long in a trial that is judged: one period."""


class Verdict(NamedTuple):
    """Result of a trial."""

    wrong: str
    """Why it counts as missed; "" if it doesn't."""
    late_s: float
    """Time in [s] by which a period of its bench or program was too long, at most."""

    @property
    def is_judged(self) -> bool:
        """Return whether the machine was fast enough; the result of the trial plays no part."""
        return self.late_s <= LATE_LIMIT_S


class Tally:
    """Counts of one row: judged trials, and those that are not because a loop was late.

    Bench and program have to keep their period. Where one of both is late, a message that is missing or a
    base that rests late says nothing of the program. Such a trial is not judged, whether it was good or
    not, and counted apart.
    """

    def __init__(self, verdicts: Sequence[Verdict]) -> None:
        """Count the trials of a row."""
        self._judged = [verdict for verdict in verdicts if verdict.is_judged]
        self._others = [verdict for verdict in verdicts if not verdict.is_judged]

    @property
    def missed(self) -> int:
        """Number of judged trials that were missed; a row without a judged trial counts as one."""
        return sum(bool(verdict.wrong) for verdict in self._judged) if self._judged else 1

    @property
    def words(self) -> str:
        """Counts, such as `17/18, not judged 2 (a loop was up to 0.31 s late; 1 of them good)`."""
        good = sum(not verdict.wrong for verdict in self._judged)
        counts = f"{good}/{len(self._judged)}"
        if not self._others:
            return counts
        late = max(verdict.late_s for verdict in self._others)
        fine = sum(not verdict.wrong for verdict in self._others)
        apart = f"a loop was up to {late:.2f} s late; {fine} of them good"
        return f"{counts}, not judged {len(self._others)} ({apart})"

    def findings(self) -> Iterator[str]:
        """Yield each reason of a missed trial once, those that are not judged last."""
        for verdicts, mark in ((self._judged, ""), (self._others, "not judged: ")):
            for wrong in dict.fromkeys(verdict.wrong for verdict in verdicts if verdict.wrong):
                yield f"{mark}{wrong}"
