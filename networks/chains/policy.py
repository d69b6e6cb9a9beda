"""The coordinator's decisions in a network, for every combination of Fails."""

from __future__ import annotations

from bisect import insort
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from handcart.networks.analysis.ahead import Ahead
from handcart.networks.analysis.plan_search import PlanSearch
from handcart.networks.graph.network import Action, ActionNetwork

from .effort import Effort, TooMuch

DEFAULT_MAX_STEPS = 500_000
"""Default budget of a question, in steps: one or two seconds of computation."""


class TooLarge(Exception):
    """A part of the network has too many states for exact figures."""

    def __init__(self, network: ActionNetwork, count: int) -> None:
        part = f"between {network.start} and {network.goal}"
        super().__init__(f"the part {part} has more than {count} states; fewer attempts make it smaller")


class State(NamedTuple):
    """A state in which the coordinator plans."""

    situation: str
    fails: tuple[tuple[int, int], ...]
    """Number and Fails of each action that failed and can still come up; its attempts, where it is out."""


class Step(NamedTuple):
    """Decision of the coordinator in a state: a plan that is followed until something fails."""

    plan: tuple[Action, ...]
    """Planned actions; empty if no route is left."""
    after_fail: tuple[State | None, ...]
    """State after a Fail of each of these actions; None for a skip, which cannot fail."""
    for_good: tuple[State | None, ...]
    """State after a Fail for good of each action; empty if those are not considered."""


@dataclass(frozen=True)
class Policy:
    """The coordinator's decisions as an acyclic graph: attempts are limited."""

    network: ActionNetwork
    start: State
    steps: dict[State, Step]
    """Decisions by state; successors come before their predecessors. States in the goal are not included."""


def policy(
    network: ActionNetwork,
    for_good: bool = False,
    effort: Effort | None = None,
    start: State | None = None,
) -> Policy:
    """Return all that can happen from the start of a network.

    Fails of actions that cannot come up again are forgotten: the paper's task then has some hundred states,
    not hundreds of thousands.

    Args:
        network: the network.
        for_good: whether to consider Fails that use up all attempts at once.
        effort: budget of the computation; None: `WORK`.
        start: another state to begin at than the network's start.

    Raises:
        TooLarge: the budget does not suffice for the number of states.
    """
    steps: dict[State, Step] = {}
    try:
        return _whole(
            network, start or State(network.start, ()), for_good, effort or Effort(DEFAULT_MAX_STEPS), steps
        )
    except TooMuch:
        raise TooLarge(network, len(steps)) from None


def _whole(
    network: ActionNetwork, start: State, for_good: bool, effort: Effort, steps: dict[State, Step]
) -> Policy:
    maker = StepMaker(network, for_good, effort)
    made: dict[State, Step] = {}
    ahead = [] if start.situation == network.goal else [start]
    while ahead:
        state = ahead[-1]
        if state not in made:
            made[state] = maker.step(state)
        left = [
            each
            for each in (*made[state].after_fail, *made[state].for_good)
            if each is not None and each.situation != network.goal and each not in steps
        ]
        if left and state not in steps:
            ahead += left
            continue
        steps[ahead.pop()] = made[state]
    return Policy(network, start, steps)


class StepMaker:
    """Factory of the steps of one network's policy."""

    def __init__(self, network: ActionNetwork, for_good: bool, effort: Effort) -> None:
        effort.spend(len(network.situations) + len(network.actions))
        self._network, self._for_good, self._effort = network, for_good, effort
        self._search, self._ahead = PlanSearch(network), Ahead(network)
        self._bits = [self._ahead.bit(action.source) for action in network.actions]

    def step(self, state: State) -> Step:
        fails = dict(state.fails)
        plan = self._search.plan(state.situation, fails)
        length = len(plan or ()) * (2 if self._for_good else 1)
        self._effort.spend(10 + 2 * self._search.steps + length * (5 + len(fails)))
        if plan is None:
            return Step((), (), ())
        once = tuple(self._failed(a, fails, fails.get(a.index, 0) + 1) for a in plan)
        good = tuple(self._failed(a, fails, a.attempts) for a in plan) if self._for_good else ()
        return Step(plan, once, good)

    def _failed(self, action: Action, fails: Mapping[int, int], count: int) -> State | None:
        if action.binding is None:
            return None
        there, bits = action.on_fail or action.source, self._bits
        if there == self._network.goal:
            return State(there, ())
        comes = self._ahead.bits(there)
        kept = [each for each in fails.items() if comes & bits[each[0]] and each[0] != action.index]
        if comes & bits[action.index]:
            insort(kept, (action.index, count))
        return State(there, tuple(kept))
