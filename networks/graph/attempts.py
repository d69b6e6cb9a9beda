"""Attempts of actions, and the number that remains."""

from __future__ import annotations

from typing import NamedTuple

MAX_ATTEMPTS = 20
"""Maximum attempts of an action; with `MAX_COST_S` it keeps doubled weights below `SKIP_WEIGHT`."""


class Attempts(NamedTuple):
    """Limit on the Fails of an action, or of several actions together, after which they are excluded.

    A renewal, after a Success of certain other actions, sets the number of Fails back to 0. A run's count
    holds Fails and renewals so far in one number, which is `renewals * width + fails`.
    """

    limit: int = 3
    """Fails after which the action is excluded."""
    renewals: int = 0
    """Maximum number of times that the count begins again, after a Success of an action in `fresh_after`."""
    unlimited: bool = False
    """True if Fails never exclude it; only a Fail for good does."""

    @property
    def width(self) -> int:
        """Amount by which a renewal of an action's attempts raises the run's count of its Fails and renewals.

        It is one more than the largest number of Fails, so that one number holds both counts.
        """
        return self.most + 1

    @property
    def most(self) -> int:
        """Number of Fails at which the action is excluded; a renewal sets the number of Fails back to 0."""
        return MAX_ATTEMPTS + 1 if self.unlimited else self.limit

    def fails(self, count: int) -> int:
        """Return the Fails since the last renewal, from a run's count of Fails and renewals.

        With unlimited attempts, at most `MAX_ATTEMPTS` are counted.
        """
        return count % self.width

    def is_out(self, count: int) -> bool:
        """Return whether the action is excluded because a run has used up its attempts.

        Args:
            count: the run's count of Fails and renewals, `renewals * width + fails`.
        """
        return count % self.width >= self.most

    def failed(self, count: int) -> int:
        """Return a run's count of an action's Fails and renewals (resets of the number of Fails) after one
        more Fail.

        Args:
            count: count before this Fail, `renewals * width + fails`.
        """
        fails = count % self.width
        last = MAX_ATTEMPTS if self.unlimited else self.limit
        return count + 1 if fails < last else count

    def used_up(self, count: int) -> int:
        """Return the count of Fails and renewals of a run after a Fail that uses up all attempts at once.

        Args:
            count: count before this Fail, `renewals * width + fails`, with the property `width`.
        """
        return count - count % self.width + self.most

    def renewed(self, count: int) -> int:
        """Return a run's count (of Fails and renewals) after a renewal, which sets the number of Fails back
        to 0.

        The count is unchanged if nothing has failed or no renewal is left.
        """
        renewals, fails = divmod(count, self.width)
        return (renewals + 1) * self.width if fails and renewals < self.renewals else count
