"""What the coordinator does in a network, whatever fails."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import networkx as nx

from networks.network import Action, ActionNetwork
from networks.planner import Plan, Planner

MOST_STATES = 20_000
"""How many states a policy may have: some seconds' work."""


class TooLarge(Exception):
    """A part of the network has too many states for exact figures."""

    def __init__(self, network: ActionNetwork, most: int) -> None:
        part = f"between {network.start} and {network.goal}"
        super().__init__(f"the part {part} has more than {most - 1} states; fewer attempts make it smaller")


class State(NamedTuple):
    """A moment at which the coordinator plans."""

    situation: str
    fails: tuple[tuple[int, int], ...]
    """Number and Fails of each action that failed and can still come up; its attempts, where it is out."""


class Step(NamedTuple):
    """What it does then: the plan is followed until something fails."""

    plan: tuple[Action, ...]
    """Empty: no way is left."""
    after_fail: tuple[State | None, ...]
    """Where a Fail of each of these actions leads; None for a skip, which can't fail."""
    for_good: tuple[State | None, ...]
    """Where a Fail for good leads; empty, where those aren't reckoned with."""


@dataclass(frozen=True)
class Policy:
    """The coordinator's decisions as an acyclic graph: attempts are limited."""

    network: ActionNetwork
    start: State
    steps: dict[State, Step]
    """What follows a state stands before it. A state in the goal's situation is none of them."""


def policy(network: ActionNetwork, for_good: bool = False) -> Policy:
    """All that can happen from the start.

    Fails of actions that can't come up again are forgotten: the paper's task then has some hundred states,
    not hundreds of thousands.

    Args:
        network: the network.
        for_good: whether Fails are reckoned with that use up all attempts at once.

    Raises:
        TooLarge: there are more than `MOST_STATES`.
    """
    maker = _Maker(network, for_good)
    start = State(network.start, ())
    steps: dict[State, Step] = {}
    made: dict[State, Step] = {}
    ahead = [] if network.start == network.goal else [start]
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
        if len(steps) > MOST_STATES:
            raise TooLarge(network, len(steps))
    return Policy(network, start, steps)


class _Maker:
    """Makes the steps of one network's policy."""

    def __init__(self, network: ActionNetwork, for_good: bool) -> None:
        self._network, self._for_good = network, for_good
        ways: nx.DiGraph[str] = nx.DiGraph()
        ways.add_nodes_from(network.situations)
        for action in network.actions:
            if action.source != network.goal:
                ways.add_edges_from((action.source, to) for to in (action.target, action.on_fail) if to)
        self._ahead = {name: {name, *nx.descendants(ways, name)} for name in network.situations}

    def step(self, state: State) -> Step:
        planner = Planner(self._network)
        actions = self._network.actions
        for index, count in state.fails:
            for _ in range(count):
                planner.failed(actions[index], "imagined")
        plan = planner.plan(state.situation)
        if not isinstance(plan, Plan):
            return Step((), (), ())
        fails = dict(state.fails)
        once = tuple(self._failed(a, fails, fails.get(a.index, 0) + 1) for a in plan.actions)
        good = tuple(self._failed(a, fails, a.attempts) for a in plan.actions) if self._for_good else ()
        return Step(plan.actions, once, good)

    def _failed(self, action: Action, fails: Mapping[int, int], count: int) -> State | None:
        if action.binding is None:
            return None
        there, actions = action.on_fail or action.source, self._network.actions
        if there == self._network.goal:
            return State(there, ())
        known = {**fails, action.index: count}
        kept = sorted((n, c) for n, c in known.items() if actions[n].source in self._ahead[there])
        return State(there, tuple(kept))
