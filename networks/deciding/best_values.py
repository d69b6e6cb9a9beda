"""Least expected cost from states of a network, with every limit on attempts counted."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.networks.chains.effort import Effort, TooMuch
from handcart.networks.chains.step_maker import State
from handcart.networks.graph.network import Action

from .component_search import ComponentSearch
from .process import Process, ProcessOption
from .situation_values import MAX_TIGHT_SITUATIONS, SituationValues
from .state_rows import counters_of

VALUE_GAPS = (0.1, 1e-2, 8e-4, 1e-5, 1e-7, 1e-9)
"""Relative differences between the bounds of a value, aimed at one after the other within the budget."""
SUFFICIENT_GAP = 8e-4
"""Gap that may cost the whole budget."""
FINER_SHARE = 0.15
"""Share of the rest that each smaller gap may cost: few decisions depend on it."""
FINER_FACTOR = 3.0
"""Least cost of a smaller gap, relative to that of all gaps before: one that its share of the budget cannot
pay for is not begun.
"""
LATER_STEPS = 60_000.0
"""Budget of each further decision once the first one's is spent, in steps; some 0.2 s."""
OPENING_STEPS, VISIT_STEPS = 50.0, 4.0
"""Effort of finding the options of a state, and of looking at them once."""


class Decision(NamedTuple):
    """Best decision in a state, with bounds of its expected cost."""

    action: Action | None
    """The action; None if calling a person costs no more than any action."""
    cost: float
    """Upper bound of the expected cost from here on if the action is done, in [s]."""
    low: float
    """Lower bound of the expected cost of any policy from here on, in [s]."""


class BestValues:
    """Search for the best decisions in a state and in all states that may follow it.

    A decision is searched for when it is first needed.

    The states form a graph, which is solved by its strongly connected components, each after those to which
    it leads. A component in which a run may come back to a state is solved by `ComponentSearch`. In the other
    components, each state is solved from its successors.
    """

    def __init__(self, process: Process, effort: Effort) -> None:
        """Compute the lower bounds.

        Args:
            process: the network.
            effort: budget of all searches together.
        """
        self.process = process
        self._bounds = SituationValues(process)
        self._effort = effort
        self._low: dict[State, float] = {}
        self._high: dict[State, float] = {}
        self._options: dict[State, list[ProcessOption]] = {}
        self._settled: dict[State, int] = {}
        self._searches: dict[tuple[int, tuple[int, ...]], ComponentSearch] = {}
        self._counters: dict[str, frozenset[int] | None] = {}
        self._gap = 0
        self._is_spent = False

    def decision(self, state: State) -> Decision:
        """Return the best decision (action to start, or calling a person) in a state.

        The decision is searched for as long as the budget allows.
        """
        if self._is_spent and state not in self._settled:
            self._effort = Effort(LATER_STEPS)
        spent_before = self._effort.spent
        for number in range(len(VALUE_GAPS)):
            if self._settled.get(state, -1) >= number:
                continue
            self._gap, whole = number, self._effort
            if VALUE_GAPS[number] < SUFFICIENT_GAP:
                if FINER_SHARE * whole.left < FINER_FACTOR * (whole.spent - spent_before):
                    self._settled[state] = len(VALUE_GAPS)
                    break
                self._effort = whole.part(FINER_SHARE)
            try:
                self._settle_all(state)
            except TooMuch:
                self._settled[state] = len(VALUE_GAPS)
            self._effort = whole
        self._is_spent = self._effort.left < LATER_STEPS
        return self.known(state)

    def _settle_all(self, state: State) -> None:
        """Settle a state with all that it depends on."""
        ahead = [state]
        while ahead:
            needed = self._settle(ahead[-1])
            if needed is None:
                ahead.pop()
            else:
                ahead.append(needed)

    def known(self, state: State) -> Decision:
        """Return the best decision in a state by the cost bounds computed so far, without searching."""
        if state.situation == self.process.network.goal:
            return Decision(None, 0.0, 0.0)
        search = self._search(state)
        if search is not None and (found := search.decision(state)) is not None:
            return Decision(*found)
        return self._best_known(state)

    def likely(self, state: State) -> Decision | None:
        """Return the best decision in a state by the bounds computed so far, without searching.

        The result is None if the search has not examined the state, or if the state is not among those that
        runs of the best policy reach most often.
        """
        search = self._search(state)
        if search is None:
            return self._best_known(state) if state in self._options else None
        found = search.likely_decision(state)
        return None if found is None else Decision(*found)

    def _best_known(self, state: State) -> Decision:
        """Return the best decision by the bounds of the states that follow."""
        best, action = self.process.stop_price(state.situation), None
        for option in self._options.get(state) or self.process.options(state):
            if (cost := self._expected(option)) < best:
                best, action = cost, option.action
        return Decision(action, best, min(best, self._bounds_of(state)[0]))

    def costs(self, state: State) -> list[Decision]:
        """Return each action that can be started in a state, with its expected cost; the cheapest first.

        The cost assumes that all later decisions are the best ones.
        """
        found = []
        for option in self.process.options(state):
            for _, item in option.leads:
                self.decision(item)
            high, low = self._expected(option), self._expected_low(option)
            found.append(Decision(option.action, high, min(high, low)))
        return sorted(found, key=lambda item: item.cost)

    def _settle(self, root: State) -> State | None:
        """Settle a state; return another one of a later component that has to be settled first, if any."""
        if self._is_settled(root) or root.situation == self.process.network.goal:
            return None
        search = self._search(root)
        if search is None:
            return self._settle_exactly(root)
        needed = search.settle(root, VALUE_GAPS[self._gap], self._effort, self._settled_bounds)
        if needed is None:
            self._settled[root] = self._gap
        return needed

    def _search(self, state: State) -> ComponentSearch | None:
        """Return the search of the component of a state; None if no run comes back to the state."""
        own = self._own_counters(state.situation)
        if own is None:
            return None
        carried = tuple([counter for counter, _ in state.fails if counter not in own])
        place = self.process.part[state.situation], carried
        found = self._searches.get(place)
        if found is None:
            found = self._searches[place] = ComponentSearch(self.process, self._bounds, *place)
        return found

    def _own_counters(self, situation: str) -> frozenset[int] | None:
        """Return the counters of a situation's component; None if no run comes back to its states."""
        try:
            return self._counters[situation]
        except KeyError:
            own = None
            if not self._is_acyclic(situation):
                own = frozenset(counters_of(self.process, self.process.part[situation]))
            self._counters[situation] = own
            return own

    def _settled_bounds(self, state: State) -> tuple[float, float] | None:
        return self._bounds_of(state) if self._is_settled(state) else None

    def _bounds_of(self, state: State) -> tuple[float, float]:
        """Return the bounds of a state, in [s]; those of its situation if it was not looked at."""
        search, stop = self._search(state), self.process.stop_price(state.situation)
        if search is None:
            return self._lower(state), self._high.get(state, stop)
        return search.bounds(state) or (self._bounds.value[state.situation], stop)

    def _is_acyclic(self, situation: str) -> bool:
        """Return whether no run that has left a state of a situation comes back to it."""
        process = self.process
        if len(process.parts[process.part[situation]]) > 1:
            return False
        network = process.network
        return not any(item.index in network.renewed_by for item in process.out[situation])

    def _settle_exactly(self, root: State) -> State | None:
        """Settle a state from those that follow it, likely better actions first; or return one of these."""
        settled, stop = self._settled, self.process.stop_price(root.situation)
        best = stop
        options = self._opened(root)
        for low, number in sorted(
            (self._expected_low(option), number) for number, option in enumerate(options)
        ):
            if low >= best:
                break
            for _, item in options[number].leads:
                if settled.get(item, -1) < self._gap:
                    return item
            best = min(best, self._expected(options[number]))
        self._improve(root)
        exact = self._low[root] >= self._high[root] * (1.0 - VALUE_GAPS[-1])
        self._settled[root] = len(VALUE_GAPS) if exact else self._gap
        return None

    def _is_settled(self, state: State) -> bool:
        return self._settled.get(state, -1) >= self._gap

    def _improve(self, state: State) -> None:
        """Improve the bounds of a state by those of the states that follow."""
        low = high = price = self.process.stop_price(state.situation)
        for option in self._opened(state):
            low = min(low, self._expected_low(option))
            high = min(high, self._expected(option))
        before = self._low.get(state, 0.0), self._high.get(state, price)
        self._low[state], self._high[state] = max(before[0], min(low, high)), min(before[1], high)

    def _opened(self, state: State) -> list[ProcessOption]:
        if state not in self._options:
            self._effort.spend(OPENING_STEPS)
            self._options[state] = self.process.options(state)
        self._effort.spend(VISIT_STEPS)
        return self._options[state]

    def _expected(self, option: ProcessOption) -> float:
        cost, left, high = option.cost, 1.0 - option.stays, self._high
        for p, state in option.leads:
            value = high.get(state)
            cost += p * (self._bounds_of(state)[1] if value is None else value)
        return cost / left if left > 0.0 else math.inf

    def _expected_low(self, option: ProcessOption) -> float:
        cost, left, low = option.cost, 1.0 - option.stays, self._low
        for p, state in option.leads:
            value = low.get(state)
            cost += p * (self._bounds_of(state)[0] if value is None else value)
        return cost / left if left > 0.0 else math.inf

    def _lower(self, state: State) -> float:
        """Return the lower bound of a state; the one of its situation if it was not looked at."""
        if state in self._low:
            return self._low[state]
        process, situation = self.process, state.situation
        out = frozenset[int]()
        if state.fails and len(process.parts[process.part[situation]]) <= MAX_TIGHT_SITUATIONS:
            out = self._excluded(state)
        self._low[state] = bound = self._bounds.without(situation, out)
        return bound

    def _excluded(self, state: State) -> frozenset[int]:
        """Return the excluded actions in the component of a state that no renewal brings back."""
        shared, part = self.process.network.shared, self.process.part
        here, found = part[state.situation], list[int]()
        for counter, count in state.fails:
            for action in shared[counter]:
                allowed = action.allowance
                if allowed.is_out(count) and not allowed.renewals and part[action.source] == here:
                    found.append(action.index)
        return frozenset(found)
