"""The seed of a run that goes on from an instant in several ways."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Branch(NamedTuple):
    """One of the ways in which a run goes on."""

    number: int
    """Tells its draws from those of the others, from 1 on."""
    drawn: Mapping[str, int]
    """For each purpose the last period of which something was drawn before."""


class SplitSeed(int):
    """A seed whose draws are, up to an instant, those of the run that was split there, and from there on
    this branch's own: the robot and the world stay the same, what is still to come doesn't.

    It notes what has been drawn, so that a branch can be split again. Its value is that of the plain seed, so
    that what a backend draws without `keyed` is the same in all branches.
    """

    _branches: tuple[Branch, ...]
    _drawn: dict[str, int]

    def __new__(cls, seed: int, branches: tuple[Branch, ...] = ()) -> SplitSeed:
        """Of a plain seed; `branches` are those that were taken by now, the last one last."""
        made = super().__new__(cls, seed)
        made._branches, made._drawn = branches, {}
        return made

    def split(self, number: int) -> SplitSeed:
        """The seed of a branch that begins here; the number is another one than all branches have."""
        return SplitSeed(int(self), (*self._branches, Branch(number, dict(self._drawn))))

    def branch(self, purpose: str, period: int) -> int:
        """Whose draw it is; 0: that of the plain seed. It is noted."""
        self._drawn[purpose] = max(period, self._drawn.get(purpose, period))
        for branch in reversed(self._branches):
            if period > branch.drawn.get(purpose, -1):
                return branch.number
        return 0
