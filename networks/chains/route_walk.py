"""Walk of many runs along their routes, until each has failed or ended."""

from __future__ import annotations

from collections.abc import Generator, Iterator

import numpy as np

from handcart.networks.graph.network import ActionNetwork
from handcart.robotics.numerics.arrays import FloatArray, IntArray, Uint16Array

from .chain_rows import ChainEnd
from .chance import Chance
from .count_routes import NO_ACTION, CountRoutes, RouteFinder
from .effort import TooMuch
from .flow_states import FlowStates, StateCodes
from .policy import Chances, fail_shares
from .step_maker import StepMaker


class RouteWalk:
    """Computation of the ends of all runs in which each next action is the first of the cheapest plan to the
    goal.

    The probabilities and costs of all runs that end alike are added up.
    """

    def __init__(self, network: ActionNetwork, chances: Chances, maker: StepMaker, codes: StateCodes) -> None:
        """Prepare the arrays of a network for which `can_flow` holds.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None if it skips an element.
            maker: maker of single steps, for routes of the same cost.
            codes: rows of the states.
        """
        self._network, self._maker, self._codes = network, maker, codes
        self._finder = RouteFinder(network)
        self._prepare(network, chances)
        self.ends = np.zeros((len(network.situations), len(ChainEnd), 6 if self._is_skip.any() else 3))
        """(situations, ends, 3 or 6) moments of the runs that ended, by `ChainEnd`, as in `FlowStates`."""
        self.starts, self.skips = np.zeros(len(network.actions)), 0.0
        self.stuck = self.stuck_fails = 0
        """Number of states from which no route led on, and number of actions that had failed in them."""

    def _prepare(self, network: ActionNetwork, chances: Chances) -> None:
        place = self._codes.place
        counters = list(network.shared)
        known = [chance or Chance(1.0) for chance in chances]
        self._goal = place[network.goal]
        self._is_skip = np.array([action.binding is None for action in network.actions])
        self._cost = np.array([a.cost_s if a.binding else 0.0 for a in network.actions])
        self._success = np.array([chance.success for chance in known])
        self._gives_up = np.array([chance.give_up for chance in known])
        self._target = np.array([place[action.target] for action in network.actions])
        self._column = np.array([counters.index(action.counter) for action in network.actions])
        most = 1 + max(len(action.fail_endings) for action in network.actions)
        self._fail = np.zeros((most, len(known)))
        self._after_fail = np.zeros((most, len(known)), np.int64)
        for action, chance in zip(network.actions, known, strict=True):
            every = [action.on_fail, *(ending.target for ending in action.fail_endings)]
            for number, (share, to) in enumerate(zip(fail_shares(action, chance), every, strict=True)):
                self._fail[number, action.index] = chance.fail * share
                self._after_fail[number, action.index] = place[to or action.source]

    def after(self, states: FlowStates) -> Iterator[FlowStates]:
        """Follow runs from `states` until each run has one more Fail or has ended.

        Equal rows of `states.counts` have to be adjacent.

        Yield the states after these Fails; add the probability and cost of runs that end to `ends`.
        """
        counts, place, mass = states
        first = np.append(True, (counts[1:] != counts[:-1]).any(axis=1))
        counts, tree = counts[first], np.cumsum(first) - 1
        routes = self._finder.routes(counts)
        stuck = routes.action[place, tree] == NO_ACTION
        yield from self._walk(routes, counts, tree[~stuck], place[~stuck], mass[~stuck])
        if stuck.any():
            trees, tree = np.unique(tree[stuck], return_inverse=True)
            hoping = self._finder.hoping(counts[trees])
            yield from self._walk(hoping, counts[trees], tree, place[stuck], mass[stuck])

    def _walk(
        self, routes: CountRoutes, counts: Uint16Array, tree: IntArray, place: IntArray, mass: FloatArray
    ) -> Iterator[FlowStates]:
        """Follow the runs along their routes to the routes' ends; yield the states after the Fails.

        Args:
            routes: the routes.
            counts: (trees, counters) numbers of Fails; all states with equal ones share a tree of routes.
            tree: (n,) index in `counts` of the tree that each run follows.
            place: (n,) situation of each run.
            mass: (n, 3 or 6) moments of each, as in `FlowStates`.
        """
        trees = len(counts)
        first, tied, fails = routes.action.ravel(), routes.is_tied.ravel(), routes.has_to_fail.ravel()
        while len(tree):
            at = place * trees + tree
            action, is_tied = first[at], tied[at]
            ended = action == NO_ACTION
            if ended.any() or is_tied.any():
                self._end(place[ended], ChainEnd.NO_WAY, mass[ended])
                self.stuck += int(np.count_nonzero(ended))
                self.stuck_fails += int(np.count_nonzero(counts[tree[ended]]))
                for number in np.flatnonzero(is_tied & ~ended).tolist():
                    yield from self._singly(counts[tree[number]], int(place[number]), mass[number])
                going = np.flatnonzero(~(is_tied | ended))
                at, tree, place, action, mass = (
                    at[going],
                    tree[going],
                    place[going],
                    action[going],
                    mass[going],
                )
            has_to_fail = fails[at]
            mass = yield from self._attempted(counts, tree, place, action, mass)
            place = self._target[action]
            if has_to_fail.any():
                chosen = np.flatnonzero(has_to_fail)
                yield self._more(counts, tree[chosen], action[chosen], place[chosen], mass[chosen])
            at_goal = place == self._goal
            ends = np.flatnonzero(at_goal & ~has_to_fail)
            self._end(place[ends], ChainEnd.GOAL, mass[ends])
            goes_on = np.flatnonzero(~(at_goal | has_to_fail))
            tree, place, mass = tree[goes_on], place[goes_on], mass[goes_on]

    def _attempted(
        self, counts: Uint16Array, tree: IntArray, place: IntArray, action: IntArray, mass: FloatArray
    ) -> Generator[FlowStates, None, FloatArray]:
        """Start one action in each of n states; yield the states after Fails, return the moments after
        Successes.

        Args:
            counts: (trees, counters) numbers of Fails.
            tree: (n,) index in `counts` of each state.
            place: (n,) numbers of the situations.
            action: (n,) numbers of the actions.
            mass: (n, 3 or 6) moments of the runs, as in `FlowStates`.
        """
        is_skip = self._is_skip[action]
        mass = _later(mass, self._cost[action])
        started = mass[:, ::3].sum(axis=1)
        self.starts += np.bincount(action, started * ~is_skip, len(self.starts))
        if is_skip.any():
            self.skips += float(started[is_skip].sum())
            mass[is_skip] = np.hstack((np.zeros((is_skip.sum(), 3)), mass[is_skip, :3] + mass[is_skip, 3:]))
        self._end(place, ChainEnd.GIVE_UP, mass * self._gives_up[action, None])
        for fail, to in zip(self._fail, self._after_fail, strict=True):
            yield self._more(counts, tree, action, to[action], mass * fail[action, None])
        return np.asarray(mass * self._success[action, None])

    def _more(
        self, counts: Uint16Array, tree: IntArray, action: IntArray, place: IntArray, mass: FloatArray
    ) -> FlowStates:
        """Return the states after one more Fail of an action in each of n states, without the goal and
        impossible states.

        Args:
            counts: (trees, counters) numbers of Fails.
            tree: (n,) index in `counts` of each state.
            action: (n,) numbers of the actions.
            place: (n,) numbers of the situations after the Fails.
            mass: (n, 3 or 6) moments of the runs, as in `FlowStates`.
        """
        comes = mass[:, ::3].sum(axis=1) > 0.0
        at_goal = place == self._goal
        self._end(place[at_goal], ChainEnd.GOAL, mass[at_goal])
        chosen = np.flatnonzero(comes & ~at_goal)
        more = counts[tree[chosen]]
        more[np.arange(len(chosen)), self._column[action[chosen]]] += 1
        return self._codes.forgotten(FlowStates(more, place[chosen], mass[chosen]))

    def _singly(self, counts: Uint16Array, place: int, mass: FloatArray) -> Iterator[FlowStates]:
        """Follow the plan of one state, as `StepMaker` chooses among routes of the same cost.

        Args:
            counts: (counters,) numbers of Fails.
            place: number of the situation.
            mass: (3 or 6,) moments of the runs, as in `FlowStates`.
        """
        state, every, flow = self._codes.state(counts, place), counts[None, :], mass[None, :]
        only = np.zeros(1, np.int64)
        while state.situation != self._network.goal:
            here = np.array([self._codes.place[state.situation]])
            try:
                step = self._maker.step(state)
            except TooMuch:
                self._end(here, ChainEnd.UNKNOWN, flow)
                return
            if step.action is None:
                self._end(here, ChainEnd.NO_WAY, flow)
                self.stuck += 1
                self.stuck_fails += int(np.count_nonzero(counts))
                return
            action, counter, after = np.array([step.action.index]), step.action.counter, step.succeeded[0]
            flow = yield from self._attempted(every, only, here, action, flow)
            assert after is not None
            if dict(after.fails).get(counter, 0) > dict(state.fails).get(counter, 0):
                yield self._more(every, only, action, self._target[action], flow)
                return
            state = after
        self._end(np.array([self._goal]), ChainEnd.GOAL, flow)

    def _end(self, place: IntArray, end: ChainEnd, mass: FloatArray) -> None:
        if len(place):
            for moment, values in enumerate(mass.T):
                self.ends[:, end, moment] += np.bincount(place, values, len(self.ends))


def _later(mass: FloatArray, cost: FloatArray) -> FloatArray:
    """Return the moments (n, 3 or 6) of runs after one more step with a cost (n,), in [s]."""
    later = mass.copy()
    for at in range(0, mass.shape[1], 3):
        later[:, at + 1] += cost * mass[:, at]
        later[:, at + 2] += cost * (2.0 * mass[:, at + 1] + cost * mass[:, at])
    return later
