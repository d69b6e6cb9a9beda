"""Probability and cost of an end, composable over consecutive parts of a run."""

from __future__ import annotations

from typing import NamedTuple


class Moments(NamedTuple):
    """Probability that a run leaves a part of a network by a certain exit, and moments of its cost C.

    `p` is the probability. `first` is E[C; exit], the expected cost counted only for runs that leave by this
    exit (0 for all others), in [s]; `second` is E[C²; exit], in [s²].
    """

    p: float
    first: float = 0.0
    second: float = 0.0

    def __add__(self, other: object) -> Moments:
        """Return the moments of either of two mutually exclusive cases."""
        assert isinstance(other, Moments)
        return Moments(self.p + other.p, self.first + other.first, self.second + other.second)

    def then(self, other: Moments) -> Moments:
        """Return the probability and cost moments of this step followed by an independent step `other`."""
        return Moments(
            self.p * other.p,
            self.first * other.p + self.p * other.first,
            self.second * other.p + 2.0 * self.first * other.first + self.p * other.second,
        )


def certain(p: float, cost: float) -> Moments:
    """Return the moments of a step that is taken with probability `p` at a fixed `cost` in [s].

    They are p, p cost and p cost².
    """
    return Moments(p, p * cost, p * cost * cost)
