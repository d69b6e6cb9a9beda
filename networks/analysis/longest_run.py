"""The longest run that a policy allows."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.networks.chains.policy import Policy


class Longest(NamedTuple):
    """The most actions that a run through a part can start, [-inf] where no run ends so."""

    through: float
    """Most actions of runs that reach the part's goal."""
    ended: float
    """Most actions of runs that end in the part."""

    def then(self, rest: Longest) -> Longest:
        """Return the longest run through this part and then the other."""
        return Longest(self.through + rest.through, max(self.ended, self.through + rest.ended))


def longest_run(policy: Policy) -> Longest:
    """Return the longest run of a policy, computed backwards from its ends.

    The policy should include Fails for good.
    """
    goal = policy.network.goal
    known: dict[object, Longest] = {}
    for state, step in policy.steps.items():
        through, ended = -math.inf, -math.inf if step.plan else 0.0
        count = 0
        for number, action in enumerate(step.plan):
            if action.binding is None:
                continue
            count += 1
            ended = max(ended, count)  # a GiveUp
            for after in {step.after_fail[number], step.for_good[number] if step.for_good else None} - {None}:
                assert after is not None
                rest = Longest(0.0, -math.inf) if after.situation == goal else known[after]
                through, ended = max(through, count + rest.through), max(ended, count + rest.ended)
        known[state] = Longest(max(through, count) if step.plan else through, ended)
    return known.get(policy.start, Longest(0.0, -math.inf))
