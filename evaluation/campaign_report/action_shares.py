"""How often each action succeeded, failed and gave up: what a task's `p` and `p_give_up` can come from."""

from __future__ import annotations

from dataclasses import dataclass

from .intervals import wilson


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
        return wilson(self.success, self.attempts)
