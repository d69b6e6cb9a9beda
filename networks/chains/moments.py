"""Probability and cost of an end, composable over consecutive parts of a run."""

from __future__ import annotations

from typing import NamedTuple


class Moments(NamedTuple):
    """Probability, E[C; exit] and E[C²; exit] of the cost C over the runs that leave a part by one exit."""

    p: float
    first: float = 0.0
    second: float = 0.0

    def __add__(self, other: object) -> Moments:
        """Either of two ways that exclude each other."""
        assert isinstance(other, Moments)
        return Moments(self.p + other.p, self.first + other.first, self.second + other.second)

    def then(self, other: Moments) -> Moments:
        """One after the other, independent."""
        return Moments(
            self.p * other.p,
            self.first * other.p + self.p * other.first,
            self.second * other.p + 2.0 * self.first * other.first + self.p * other.second,
        )


def certain(p: float, cost: float) -> Moments:
    """A step with probability `p` that costs this much."""
    return Moments(p, p * cost, p * cost * cost)
