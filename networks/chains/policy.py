"""The coordinator's decisions in a network, for every combination of Fails."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from handcart.networks.graph.network import Action, ActionNetwork

from .chance import Chance
from .effort import Effort, TooMuch
from .few_collections import few_collections
from .step_maker import State as State
from .step_maker import Step as Step
from .step_maker import StepMaker

DEFAULT_MAX_STEPS = 500_000
"""Default budget of a question, in steps: one or two seconds of computation."""
STEPS_PER_ACTION = 400
"""Further budget for each action of the network."""
Chances = Sequence[Chance | None]
"""Outcome probabilities of each action by its number; None if it skips an element, which always succeeds."""


def budget_of(network: ActionNetwork) -> int:
    """Return the default budget of a network's analysis, in steps of search."""
    return DEFAULT_MAX_STEPS + STEPS_PER_ACTION * len(network.actions)


class TooLarge(Exception):
    """Error, because a part of the network has too many states for exact figures."""

    def __init__(self, network: ActionNetwork, count: int) -> None:
        self.part = f"between {network.start} and {network.goal}"
        """Its place in the network, in words."""
        self.count = count
        """Number of states that were looked at."""
        states = f"more than {count} states; fewer attempts make it smaller"
        super().__init__(f"the part {self.part} has {states}")


@dataclass(frozen=True)
class Policy:
    """Next action in each state that runs can reach, and the states that may follow, as a graph of states."""

    network: ActionNetwork
    start: State
    steps: dict[State, Step]
    """Decisions by state; without circles, successors come before their predecessors. States in the goal
    are not included.
    """
    circles: bool = False
    """True if chance may lead a run back to a state."""
    is_complete: bool = True
    """False if states that a run may reach are missing."""

    def goal(self, state: State) -> bool:
        """Return whether a state is at the goal: its situation is the goal of the network."""
        return state.situation == self.network.goal


def policy(
    network: ActionNetwork,
    for_good: bool = False,
    effort: Effort | None = None,
    start: State | None = None,
    chances: Chances | None = None,
) -> Policy:
    """Return the decisions of the cheapest-route rule in all states that runs can reach from the start.

    The rule takes the cheapest route to the goal; each Fail doubles an action's cost.

    Args:
        network: the network.
        for_good: whether to include Fails that use up all attempts at once.
        effort: budget in steps of search; None: the network's default (`budget_of`).
        start: state in which the runs begin; None: the network's start without a Fail.
        chances: outcome probabilities, to leave out Fails of probability 0; None: all Fails may happen.

    Raises:
        TooLarge: the budget does not suffice.
    """
    found = explored(network, for_good, effort, start, chances)
    if not found.is_complete:
        raise TooLarge(network, len(found.steps))
    return found


def explored(
    network: ActionNetwork,
    for_good: bool = False,
    effort: Effort | None = None,
    start: State | None = None,
    chances: Chances | None = None,
) -> Policy:
    """Return the decisions of the cheapest-route rule in the states that runs can reach, as far as the budget
    suffices.

    The rule takes the cheapest route to the goal. If the budget is spent, the states found so far are
    returned with `is_complete` False.

    Args:
        network: the network.
        for_good: whether to include Fails that use up all attempts at once.
        effort: budget in steps of search; None: the network's default (`budget_of`).
        start: state in which the runs begin; None: the network's start without a Fail.
        chances: outcome probabilities, to leave out Fails of probability 0; None: all Fails may happen.
    """
    begin = start or State(network.start, ())
    try:
        maker = StepMaker(network, for_good, effort or Effort(budget_of(network)), chances)
    except TooMuch:
        return Policy(network, begin, {}, is_complete=False)
    return visited(network, begin, maker.step)


@few_collections()
def visited(
    network: ActionNetwork,
    begin: State,
    step: Callable[[State], Step | None],
) -> Policy:
    """Return the decisions in all states that runs can reach from `begin`.

    Args:
        network: the network.
        begin: state in which the runs begin.
        step: function that returns the decision in a state; None for a state to be left out. If it raises
            `TooMuch`, no further state is visited. In both cases the result is not complete.
    """
    steps: dict[State, Step] = {}
    visit = _Visit(network, steps)
    try:
        visit.all_from(begin, step)
    except TooMuch:
        return Policy(network, begin, visit.made, visit.circles, is_complete=False)
    return Policy(network, begin, steps, visit.circles, not visit.left_out)


class _Visit:
    """Depth-first visit of all states."""

    def __init__(self, network: ActionNetwork, steps: dict[State, Step]) -> None:
        self.made: dict[State, Step] = {}
        self.circles = False
        self.left_out = set[State]()
        self._goal, self._steps = network.goal, steps

    def all_from(self, start: State, decide: Callable[[State], Step | None]) -> None:
        made, steps, left_out = self.made, self._steps, self.left_out
        goal, opened = self._goal, list[tuple[State, Step]]()
        ahead: list[State | None] = [start] if start.situation != goal else []
        # Hashing a state costs more than all else here, so that each is looked up as rarely as possible.
        while ahead:
            state = ahead.pop()
            if state is None:  # all states behind the one opened last are done
                done, step = opened.pop()
                steps[done] = step
                continue
            if state in made:
                continue
            found = decide(state)
            if found is None:
                left_out.add(state)
                continue
            made[state] = found
            opened.append((state, found))
            ahead.append(None)
            for item in found.following():
                if item.situation == goal:
                    continue
                if item in made:
                    self.circles = self.circles or item not in steps
                elif item not in left_out:
                    ahead.append(item)


@few_collections()
def likely_policy(network: ActionNetwork, chances: Chances, effort: Effort, start: State) -> Policy:
    """Return the decisions of the cheapest-route rule in the likeliest states of runs, as many as the budget
    allows.

    The rule takes the cheapest route to the goal; each Fail doubles an action's cost. The order of the states
    is approximate: probability that reaches a state after its decision was made is not passed on to its
    successors. The order decides only which states an incomplete policy lacks.

    Args:
        network: the network.
        chances: outcome probabilities of each action; None for an action that only skips one of the elements
            over which a part of the network is repeated.
        effort: budget; when it is spent, the states found so far are returned, as an incomplete policy.
        start: state in which the runs begin.
    """
    steps: dict[State, Step] = {}
    mass = {start: 1.0}
    order = itertools.count()
    heap = [(-1.0, next(order), start)]
    is_complete = False
    try:
        maker = StepMaker(network, False, effort, chances)
        while heap:
            share, _, state = heapq.heappop(heap)
            if state in steps or -share < mass[state]:
                continue
            steps[state] = step = maker.step(state)
            for p, item in shares(step, chances):
                if item.situation != network.goal and item not in steps:
                    mass[item] = mass.get(item, 0.0) - share * p
                    heapq.heappush(heap, (-mass[item], next(order), item))
        is_complete = True
    except TooMuch:
        pass  # the budget is spent: the policy has the states found so far
    return Policy(network, start, steps, circles=True, is_complete=is_complete)


def shares(step: Step, chances: Chances) -> Iterator[tuple[float, State]]:
    """Yield the states that follow a decision, each with its probability; GiveUp, which ends a run, is left
    out.
    """
    action = step.action
    if action is None:
        return
    chance = chances[action.index] or Chance(1.0)
    for share, state in zip(success_shares(action, chance), step.succeeded, strict=True):
        if state is not None:
            yield chance.success * share, state
    for share, state in zip(fail_shares(action, chance), step.all_failed, strict=True):
        if state is not None:
            yield chance.fail * share, state


def fail_shares(action: Action, chance: Chance) -> Sequence[float]:
    """Return the probability of each cause, given that an action Fails; all unnamed causes come first.

    The order of the named causes is that of `Action.fail_endings`.
    """
    if chance.fail_shares:
        return chance.fail_shares
    known = [ending.p for ending in action.fail_endings]
    fail = 0.0 if action.p_success is None else 1.0 - action.p_success - action.p_give_up
    if action.p_success is None or None in known:
        return [1.0 / (1 + len(known))] * (1 + len(known))
    every = [min(1.0, (p or 0.0) / fail) if fail > 0.0 else 0.0 for p in known]
    return [max(0.0, 1.0 - sum(every)), *every]


def success_shares(action: Action, chance: Chance) -> Sequence[float]:
    """Return the probability of each situation that a Success leads to, given that an action succeeds.

    The order is `Action.target`, then `Action.others`.
    """
    if chance.success_shares:
        return chance.success_shares
    if not action.others:
        return [1.0]
    if action.p_success is None:
        return [1.0 / (1 + len(action.others))] * (1 + len(action.others))
    every = [action.p or 0.0, *(other.p or 0.0 for other in action.others)]
    return [p / action.p_success for p in every]
