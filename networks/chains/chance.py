"""Outcome probabilities of an attempt."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Chance:
    """Probabilities of Success and GiveUp of one attempt of an action; the rest is Fail."""

    success: float
    give_up: float = 0.0
    fail_shares: tuple[float, ...] = ()
    """Share of each cause in the Fails, that of all unnamed causes first; empty: the shares of the file."""
    success_shares: tuple[float, ...] = ()
    """Share of each result in the Successes, the usual one first; empty: the shares of the file."""

    @property
    def fail(self) -> float:
        """Probability of Fail, from 0 to 1."""
        return 1.0 - self.success - self.give_up
