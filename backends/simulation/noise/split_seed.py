"""The seed of a run that continues from one instant in several branches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class SeedBranch(NamedTuple):
    """One of several continuations of a run that was split at one instant; each draws its own random numbers
    after the split.
    """

    number: int
    """Number of the branch, from 1, which separates its draws from those of other branches."""
    drawn: Mapping[str, int]
    """Last period with a draw before the split, by purpose."""


class SplitSeed(int):
    """Seed of one branch of a run that is split at one instant into several continuations.

    Up to the split, random numbers drawn with `keyed` equal those of the original run; afterwards each
    branch draws its own. The seed records these draws, so that a branch can be split again. Its integer
    value is that of the plain seed, so values that a backend draws without `keyed` are equal in all
    branches. The robot and the world are the same in all branches.
    """

    _branches: tuple[SeedBranch, ...]
    _drawn: dict[str, int]
    _prefix: str

    def __new__(cls, seed: int, branches: tuple[SeedBranch, ...] = ()) -> SplitSeed:
        """Make a seed from a plain one; `branches` are the splits so far, the latest one last."""
        made = super().__new__(cls, seed)
        made._branches, made._drawn, made._prefix = branches, {}, ""
        return made

    def named(self, name: str, value: int) -> SplitSeed:
        """Return the seed of one part of the robot, with the integer `value` and the branches of this seed.

        Args:
            name: name of the part, under which its draws are recorded for later splits.
            value: integer value of the returned seed.
        """
        made = SplitSeed(value, self._branches)
        made._drawn, made._prefix = self._drawn, f"{self._prefix}{name} "
        return made

    def split(self, number: int) -> SplitSeed:
        """Return the seed of a branch that begins after the draws so far.

        Args:
            number: number of the branch, from 1, different from the numbers of all other branches.
        """
        return SplitSeed(int(self), (*self._branches, SeedBranch(number, dict(self._drawn))))

    def branch(self, purpose: str, period: int) -> int:
        """Return the number of the branch (continuation of a split run) that a random draw belongs to.

        The draw is recorded for later splits.

        Args:
            purpose: purpose of the draw (a sensor, an error), as in `keyed`.
            period: number of the period in which the draw is made.

        Returns:
            Number of the branch; 0 for a draw that equals that of the original run.
        """
        purpose = self._prefix + purpose
        self._drawn[purpose] = max(period, self._drawn.get(purpose, period))
        for branch in reversed(self._branches):
            if period > branch.drawn.get(purpose, -1):
                return branch.number
        return 0
