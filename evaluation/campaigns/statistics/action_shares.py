"""Shares of Success, Fail and GiveUp of each action, from which a task's `p` and `p_give_up` can be set."""

from __future__ import annotations

from dataclasses import dataclass

from .intervals import wilson


@dataclass(frozen=True)
class ActionShare:
    """Counts of Success, Fail and GiveUp of one action, over all its attempts.

    An action inside a `repeat` of the task's file is one action, with the attempts for all elements.
    """

    action: str
    """Name from the task file: `MOVE_TO (loaded to there)`."""
    success: int
    fail: int
    give_up: int

    @property
    def attempts(self) -> int:
        """Number of attempts that ended in Success, Fail or GiveUp."""
        return self.success + self.fail + self.give_up

    @property
    def p(self) -> float:
        """Share of the attempts that ended in Success, from 0 to 1."""
        return self.success / self.attempts

    @property
    def wilson(self) -> tuple[float, float]:
        """95 % confidence interval of the probability of Success, by Wilson's score interval for a share."""
        return wilson(self.success, self.attempts)
