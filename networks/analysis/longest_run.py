"""The longest run that a policy allows."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.networks.chains.policy import Policy, State


class Longest(NamedTuple):
    """Largest numbers of actions that a run through a part of a network can start.

    There is one number for runs that reach the part's goal, and one for runs that end before it. A number is
    -inf if there is no such run.
    """

    through: float
    """Most actions of runs that reach the part's goal."""
    ended: float
    """Most actions of runs that end in the part, short of its goal."""

    def then(self, rest: Longest) -> Longest:
        """Return the largest numbers of actions for runs through this part of a network and then the part
        `rest`.
        """
        return Longest(self.through + rest.through, max(self.ended, self.through + rest.ended))


_NOWHERE = Longest(-math.inf, -math.inf)


def longest_run(policy: Policy) -> Longest:
    """Return how many actions a policy's runs start at most, if they reach the goal and if they do not.

    Both numbers are computed backwards from the runs' ends. The policy should include Fails that use up all
    attempts at once. If chance may lead a run in circles, both numbers are the upper bound
    `ActionNetwork.bound`. States for which an incomplete policy has no decision are left out.
    """
    if policy.circles:
        bound = float(policy.network.bound())
        return Longest(bound, bound)
    known: dict[State, Longest] = {}
    for state, step in policy.steps.items():
        if step.action is None:
            known[state] = Longest(-math.inf, 0.0)
            continue
        count = 0 if step.action.binding is None else 1
        rest = [
            Longest(0.0, -math.inf) if policy.goal(item) else known.get(item, _NOWHERE)
            for item in step.following()
        ]
        through = max(item.through for item in rest)
        ended = max((0.0 if count else -math.inf), *(item.ended for item in rest))  # a GiveUp
        known[state] = Longest(count + through, count + ended)
    return known.get(policy.start, Longest(0.0, -math.inf))
