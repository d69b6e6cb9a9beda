"""The end of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

RunOutcome = Literal["Success", "Fail", "GiveUp", "Cancelled", "Error"]

_STATUS: dict[RunOutcome, int] = {"Success": 0, "Fail": 3, "GiveUp": 4, "Error": 5, "Cancelled": 130}


@dataclass(frozen=True)
class RunEnd:
    """End of a run, with its outcome, the reason in words, and numbers of actions and Fails."""

    outcome: RunOutcome
    situation: str
    """The situation in which the run ended: the last that is known to hold."""
    reason: str
    """Reason in words that a person understands; empty for Success."""
    actions: int
    """Number of actions that were started."""
    fails: int
    """Number of started actions that did not succeed."""
    replans: int
    """Number of plans after the first."""
    skipped: tuple[str, ...] = ()
    """Elements of a `repeat` that were left undone."""
    cause: str = ""
    """Kind of cause of the last action that did not succeed; empty for a Success of the run, or if
    unknown.
    """
    otherwise: str = ""
    """Situation of the task's `otherwise` that was reached instead of the goal; empty for none."""
    rounds: int = 1
    """Number of rounds that began."""

    @property
    def exit_status(self) -> int:
        """Exit status of the program after the run.

        0 Success, 3 no way left, 4 a person has to help, 5 a fault of the program, 130 interrupted.
        """
        return _STATUS[self.outcome]
