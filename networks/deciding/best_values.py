"""Least expected cost from states of a network, with every limit on attempts counted."""

from __future__ import annotations

import heapq
import itertools
import math
from typing import NamedTuple

from handcart.networks.chains.effort import Effort, TooMuch
from handcart.networks.chains.step_maker import State
from handcart.networks.graph.network import Action

from .process import Process, ProcessOption
from .situation_values import SituationValues

GAPS = (0.1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9)
"""Differences of the bounds of a value, relative to it: reached one after the other, as the budget allows."""
ENOUGH = 1e-3
"""Gap that may cost the whole budget."""
FINER_SHARE = 0.15
"""Share of the rest that each smaller gap may cost: few decisions depend on it."""
FIRST_SHARE, LAST_SHARE, SHARE_STEP = 1e-3, 1e-13, 0.1
"""Probabilities of states below which they are not looked at: of the first search, the last, and the factor
between two searches.
"""
LATER_STEPS = 60_000.0
"""Budget of a decision when that of the first is spent: some 0.2 s."""
OPENING_STEPS, VISIT_STEPS = 50.0, 4.0
"""Effort of finding the options of a state, and of looking at them once."""
MAX_SWEEPS = 1000
MAX_TIGHT_SITUATIONS = 30
"""Situations of a component up to which excluded actions tighten the lower bound."""


class Decision(NamedTuple):
    """Best decision in a state, with its value."""

    action: Action | None
    """The action; None if calling a person costs no more than any action."""
    cost: float
    """Expected cost from here on if it is done, in [s]: at most this."""
    low: float
    """No policy has a lower expected cost, in [s]."""


class BestValues:
    """Search for the best decisions from states on demand, remembering all that is settled.

    In each strongly connected component the likely states of the policy that looks best are expanded, and
    their bounds are improved until they meet (LAO*, Hansen and Zilberstein 2001, with the bounds of BRTDP,
    McMahan et al. 2005).
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
        self._gap = 0
        self._is_spent = False

    def decision(self, state: State) -> Decision:
        """Return the best decision in a state, as exactly as the budget allows."""
        if self._is_spent and state not in self._settled:
            self._effort = Effort(LATER_STEPS)
        for number in range(len(GAPS)):
            if self._settled.get(state, -1) >= number:
                continue
            self._gap, whole = number, self._effort
            if GAPS[number] < ENOUGH:
                self._effort = whole.part(FINER_SHARE)
            try:
                self._settle_all(state)
            except TooMuch:
                self._settled[state] = len(GAPS)
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
        """Return what is known of the best decision in a state, without searching."""
        if state.situation == self.process.network.goal:
            return Decision(None, 0.0, 0.0)
        best, action = self.process.stop_price(state.situation), None
        for option in self._options.get(state) or self.process.options(state):
            if (cost := self._expected(option)) < best:
                best, action = cost, option.action
        return Decision(action, best, min(best, self._lower(state)))

    def is_known(self, state: State) -> bool:
        """Return whether a state was looked at."""
        return state in self._options

    def costs(self, state: State) -> list[Decision]:
        """Return all actions that can be started in a state, each followed by the best; the best first."""
        found = []
        for option in self.process.options(state):
            for _, each in option.leads:
                self.decision(each)
            high, low = self._expected(option), self._expected_low(option)
            found.append(Decision(option.action, high, min(high, low)))
        return sorted(found, key=lambda each: each.cost)

    def _settle(self, root: State) -> State | None:
        """Settle a state; return another one of a later component that has to be settled first, if any."""
        if self._is_settled(root) or root.situation == self.process.network.goal:
            return None
        if self._is_acyclic(root.situation):
            return self._settle_exactly(root)
        share = FIRST_SHARE
        while True:
            for _ in range(MAX_SWEEPS):
                order, outside, grown = self._looks_best(root, share)
                if outside is not None:
                    return outside
                change = max([self._improve(state) for state in reversed(order)])
                if self._is_close(root) or (not grown and change <= 0.1 * GAPS[self._gap] * self._high[root]):
                    break
            if self._is_close(root) or share < LAST_SHARE:
                break
            share *= SHARE_STEP
        self._settled[root] = self._gap
        return None

    def _is_acyclic(self, situation: str) -> bool:
        """Return whether no run comes back to a state of a situation, short of staying in it."""
        process = self.process
        if len(process.parts[process.part[situation]]) > 1:
            return False
        network = process.network
        return not any(each.index in network.renewed_by for each in process.out[situation])

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
            for _, each in options[number].leads:
                if settled.get(each, -1) < self._gap:
                    return each
            best = min(best, self._expected(options[number]))
        self._improve(root)
        exact = self._low[root] >= self._high[root] * (1.0 - GAPS[-1])
        self._settled[root] = len(GAPS) if exact else self._gap
        return None

    def _is_settled(self, state: State) -> bool:
        return self._settled.get(state, -1) >= self._gap

    def _is_close(self, state: State) -> bool:
        return self._high[state] - self._low[state] <= GAPS[self._gap] * self._high[state]

    def _looks_best(self, root: State, share: float) -> tuple[list[State], State | None, bool]:
        """Return the likely states of the policy that looks best, in the component of the root.

        Args:
            root: the first state.
            share: probability of a state, along one path, below which it is not looked at.

        Returns:
            The states, likely ones first; a state of another component that is not settled; and whether
            states are new.
        """
        part, options = self.process.part, self._options
        here, order, grown = part[root.situation], list[State](), False
        likely, done = {root: 1.0}, set[State]()
        number = itertools.count()
        heap = [(-1.0, next(number), root)]
        while heap:
            minus, _, state = heapq.heappop(heap)
            if state in done:
                continue
            done.add(state)
            order.append(state)
            grown |= state not in options
            option = self._looks_best_in(state)
            for p, each in () if option is None else option.leads:
                reach = -minus * p
                if reach < share or reach <= likely.get(each, 0.0) or self._is_settled(each):
                    continue
                if part[each.situation] != here:
                    return order, each, grown
                likely[each] = reach
                heapq.heappush(heap, (-reach, next(number), each))
        return order, None, grown

    def _looks_best_in(self, state: State) -> ProcessOption | None:
        best, chosen = self.process.stop_price(state.situation), None
        for option in self._opened(state):
            if (cost := self._expected_low(option)) < best:
                best, chosen = cost, option
        return chosen

    def _improve(self, state: State) -> float:
        """Improve the bounds of a state; return by how much they came closer."""
        low = high = price = self.process.stop_price(state.situation)
        for option in self._opened(state):
            low = min(low, self._expected_low(option))
            high = min(high, self._expected(option))
        before = self._low.get(state, 0.0), self._high.get(state, price)
        self._low[state], self._high[state] = max(before[0], min(low, high)), min(before[1], high)
        return max(self._low[state] - before[0], before[1] - self._high[state])

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
            cost += p * (self.process.stop_price(state.situation) if value is None else value)
        return cost / left if left > 0.0 else math.inf

    def _expected_low(self, option: ProcessOption) -> float:
        cost, left, low = option.cost, 1.0 - option.stays, self._low
        for p, state in option.leads:
            value = low.get(state)
            cost += p * (self._lower(state) if value is None else value)
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
