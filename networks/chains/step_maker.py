"""The coordinator's decision in one state, and the states that may follow."""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from handcart.networks.graph.ahead import Ahead
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.plan_search import PlanSearch

from .chance import Chance
from .effort import Effort

_NEVER = 1e-12
"""Probability below which a result counts as impossible, because sums of decimals are rounded."""


class State(NamedTuple):
    """State of a network in which a policy decides: a situation with the counted Fails."""

    situation: str
    fails: tuple[tuple[int, int], ...]
    """Counters of Fails that can still come up, each with its count, as in `Attempts`."""
    committed: tuple[int, ...] = ()
    """Actions that an earlier plan prescribes next; of several plans of the same cost one is followed.

    One that has to fail is given as `~number`.
    """


class Step(NamedTuple):
    """Decision of a policy in a state."""

    action: Action | None
    """The action; None if no route is left."""
    succeeded: tuple[State | None, ...] = ()
    """States after its Success, the one at its target first; None for a result that never happens."""
    failed: State | None = None
    """State after its Fail; None if it never fails."""
    for_good: State | None = None
    """State after its Fail for good; None if that is not considered."""
    failed_by: tuple[State | None, ...] = ()
    """States after its Fails of the causes in `Action.fail_endings`."""
    person: bool = False
    """True if the action is missing because calling a person is better."""

    def following(self) -> Iterator[State]:
        """Yield the states that may follow this step."""
        for item in (*self.succeeded, *self.all_failed, self.for_good):
            if item is not None:
                yield item

    @property
    def all_failed(self) -> tuple[State | None, ...]:
        """States after the Fails of the action, first the one for all causes without their own situation."""
        return (self.failed, *self.failed_by)


class StepMaker:
    """Factory of the steps of one network's policy."""

    def __init__(
        self,
        network: ActionNetwork,
        for_good: bool,
        effort: Effort,
        chances: Sequence[Chance | None] | None = None,
    ) -> None:
        """Prepare the search.

        Args:
            network: the network.
            for_good: whether to consider Fails that use up all attempts at once.
            effort: budget of all steps.
            chances: outcome probabilities by action, to leave out Fails of probability 0; None: all happen.
        """
        effort.spend(len(network.situations) + len(network.actions))
        self._network, self._for_good, self._effort = network, for_good, effort
        self._search, self.after = PlanSearch(network), Aftermath(network)
        self._chances = chances

    def step(self, state: State) -> Step:
        """Return the decision in a state.

        Raises:
            TooMuch: the budget is spent.
        """
        fails = dict(state.fails)
        planned = state.committed
        if not planned:
            segment = self._search.segment(state.situation, fails)
            self._effort.spend(5 + 2 * self._search.steps)
            if segment is None:
                return Step(None)
            planned = tuple(action.index for action in segment.actions)
            if segment.hopes:
                planned = (*planned[:-1], ~planned[-1])
        self._effort.spend(5 + len(fails))
        return self._followed(planned, fails)

    def _followed(self, planned: tuple[int, ...], fails: Mapping[int, int]) -> Step:
        index, hopes = (planned[0], False) if planned[0] >= 0 else (~planned[0], True)
        action = self._network.actions[index]
        chance = None if self._chances is None else self._chances[index]
        succeeded = self.after.successes(action, fails, planned[1:], hopes)
        if action.binding is None:
            return Step(action, succeeded)
        good = self.after.fail(action, fails, for_good=True) if self._for_good else None
        failed, *by_cause = self.after.fails(action, fails, chance is None or chance.fail > _NEVER)
        return Step(action, succeeded, failed, good, tuple(by_cause))


class Aftermath:
    """States after an action, without the Fails of actions that cannot come up again."""

    def __init__(self, network: ActionNetwork) -> None:
        """Compute what can follow each situation."""
        self._network, self._ahead = network, Ahead(network)
        self._bits = {
            counter: sum({self._ahead.bit(action.source) for action in actions})
            for counter, actions in network.shared.items()
        }

    def matters(self, situation: str, counter: int) -> bool:
        """Return whether an action whose Fails a counter counts can still follow in a situation."""
        return bool(self._ahead.bits(situation) & self._bits[counter])

    def successes(
        self,
        action: Action,
        fails: Mapping[int, int],
        committed: tuple[int, ...] = (),
        hopes: bool = False,
    ) -> tuple[State | None, ...]:
        """Return the states after a Success, one for each situation that it may lead to.

        Args:
            action: the action.
            fails: counts of Fails before it.
            committed: the actions that follow if it leads to its target.
            hopes: True if the plan needed the action's Fail: then its Success uses up an attempt.
        """
        after = self._renewed(action, fails)
        if hopes:
            after = {**after, action.counter: action.allowance.failed(after.get(action.counter, 0))}
        kept = committed if after is fails else ()
        others = [
            None if other.p is not None and other.p <= _NEVER else self.at(other.target, after)
            for other in action.others
        ]
        return (self.at(action.target, after, kept), *others)

    def fail(self, action: Action, fails: Mapping[int, int], for_good: bool = False) -> State:
        """Return the state after a Fail whose cause has no situation of its own.

        Args:
            action: the action.
            fails: counts of Fails before it.
            for_good: True for a Fail that uses up all attempts at once.
        """
        allowed, count = action.allowance, fails.get(action.counter, 0)
        after = allowed.used_up(count) if for_good else allowed.failed(count)
        return self.at(action.on_fail or action.source, {**fails, action.counter: after})

    def fails(self, action: Action, fails: Mapping[int, int], happens: bool = True) -> list[State | None]:
        """Return the states after a Fail, first the one for all causes without their own situation.

        Args:
            action: the action.
            fails: counts of Fails before it.
            happens: False if the action never fails: all states are then None.
        """
        if not happens:
            return [None] * (1 + len(action.fail_endings))
        after = {**fails, action.counter: action.allowance.failed(fails.get(action.counter, 0))}
        every = [action.on_fail, *(ending.target for ending in action.fail_endings)]
        return [self.at(to or action.source, after) for to in every]

    def at(self, situation: str, fails: Mapping[int, int], committed: tuple[int, ...] = ()) -> State:
        """Return the state in a situation, with the Fails that can still matter there.

        Args:
            situation: the situation.
            fails: counts of Fails by counter.
            committed: the actions that the plan prescribes next, as in `State`.
        """
        if situation == self._network.goal:
            return State(situation, ())
        if not fails:
            return State(situation, (), committed)
        comes, kept = self._ahead.bits(situation), list[tuple[int, int]]()
        for item in fails.items():
            if comes & self._bits[item[0]]:
                insort(kept, item)
        return State(situation, tuple(kept), committed)

    def _renewed(self, action: Action, fails: Mapping[int, int]) -> Mapping[int, int]:
        counters = self._network.renewed_by.get(action.index)
        if not counters or not fails:
            return fails
        actions = self._network.actions
        new = {c: actions[c].allowance.renewed(fails[c]) for c in counters if c in fails}
        return {**fails, **new} if any(fails[c] != count for c, count in new.items()) else fails
