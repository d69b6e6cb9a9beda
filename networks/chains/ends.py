"""Probabilities and costs of the ends of a part of a run."""

from __future__ import annotations

from typing import NamedTuple

from .moments import Moments, certain

NEVER_REACHED = Moments(0.0)


class Ends(NamedTuple):
    """Ends of runs through a part of a network, such as the goal or a GiveUp, with their probabilities and
    costs; each run has exactly one of them.
    """

    goal: Moments = NEVER_REACHED
    skipped: Moments = NEVER_REACHED
    """The goal is reached, but elements of a repeat were left undone."""
    no_way: Moments = NEVER_REACHED
    """Nothing is left to try."""
    give_up: Moments = NEVER_REACHED
    """A person is needed."""
    unknown: Moments = NEVER_REACHED
    """The run comes to a state that was not looked at."""

    def after(self, step: Moments) -> Ends:
        """Return the probabilities and costs of these ends, for runs that first make a step before this part.

        Args:
            step: probability and cost of the step.
        """
        return Ends(*(step.then(item) for item in self))

    def plus(self, other: Ends) -> Ends:
        """Return the sum of these ends and `other`, for runs that pass either one of two parts of the
        network.

        The probabilities and costs of each kind of end are added.
        """
        return Ends(*(a + b for a, b in zip(self, other, strict=True)))

    def then(self, rest: Ends) -> Ends:
        """Return the ends of runs through this part and then, if they reach its goal, the part `rest`."""
        short = Ends(no_way=self.no_way, give_up=self.give_up, unknown=self.unknown)
        return short.plus(rest.after(self.goal)).plus(rest.with_a_skip().after(self.skipped))

    def with_a_skip(self) -> Ends:
        """Return the ends if an element of a `repeat` (a part of the task done for each element of a list)
        was left undone before.

        The probability and cost of `goal` are then part of `skipped`.
        """
        return Ends(NEVER_REACHED, self.goal + self.skipped, self.no_way, self.give_up, self.unknown)

    def total(self) -> Moments:
        """Return the sum over all ends: the moments (`Moments`) of the cost of a run, whatever its end."""
        return self.goal + self.skipped + self.no_way + self.give_up + self.unknown


AT_GOAL = Ends(goal=certain(1.0, 0.0))
