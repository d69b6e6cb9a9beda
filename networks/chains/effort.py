"""Budget for an exact computation."""

from __future__ import annotations

from collections.abc import Callable

_EVERY = 2000  # steps between two checks by the observer


class TooMuch(Exception):
    """Error, because a computation would exceed its budget."""


class Effort:
    """Budget of a computation, counted in steps of search instead of seconds, so that a file gets the same
    answer on every machine.
    """

    def __init__(
        self,
        most: float,
        watch: Callable[[float], None] = lambda share: None,
        whole: Effort | None = None,
    ) -> None:
        """Create a budget of which nothing is spent.

        Args:
            most: steps that may be spent; about 300,000 take a second.
            watch: called from time to time with the share that is spent, 0 to 1.
            whole: the larger budget of which this one is a part: both are spent together.
        """
        self._most, self._watch, self._whole = most, watch, whole
        self._spent, self._next = 0.0, 0.0

    def spend(self, steps: float) -> None:
        """Reduce the budget by a number of steps; raises `TooMuch` if it is used up."""
        self._spent += steps
        if self._spent > self._most:
            raise TooMuch
        if self._whole is not None:
            self._whole.spend(steps)
        if self._spent > self._next:
            self._next = self._spent + _EVERY
            self._watch(self._spent / self._most)

    @property
    def spent(self) -> float:
        """Number of steps of search that were spent from this budget so far."""
        return self._spent

    @property
    def left(self) -> float:
        """Number of steps of search that may still be spent from this budget."""
        return self._most - self._spent

    def half(self) -> Effort:
        """Return a part of this budget: half of the steps left, so that later computations have the rest."""
        return self.part(0.5)

    def part(self, share: float) -> Effort:
        """Return a part of this budget: the given share (0 to 1) of the steps of search that are left."""
        return Effort((self._most - self._spent) * share, whole=self)
