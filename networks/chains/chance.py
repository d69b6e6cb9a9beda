"""Outcome probabilities of an attempt."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Chance:
    """Probabilities of one attempt of an action; the rest is Fail."""

    success: float
    give_up: float = 0.0

    @property
    def fail(self) -> float:
        """Probability of Fail, from 0 to 1."""
        return 1.0 - self.success - self.give_up
