"""The coordinator's decision in one state, and the states that may follow."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from handcart.networks.graph.ahead import Ahead
from handcart.networks.graph.attempts import Attempts
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.plan_search import PlanSearch

from .chance import Chance
from .effort import Effort

Fails = tuple[tuple[int, int], ...]
"""Counters of Fails, ascending, each with its count, as in `Attempts`."""
_NEVER = 1e-12
"""Probability below which a result counts as impossible, because sums of decimals are rounded."""


class State(NamedTuple):
    """State of a run in which a policy decides, given by its situation and its earlier Fails."""

    situation: str
    fails: Fails
    """Fails of actions that can still come up."""
    committed: tuple[int, ...] = ()
    """Actions that an earlier plan prescribes next; of several plans of the same cost one is followed.

    One that has to fail is given as `~number`.
    """


class Step(NamedTuple):
    """Next action that a policy chooses in a state of a run, with the states to which its results lead."""

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
        """Yield the states that may follow this step, after any Success or Fail of its action."""
        for item in (*self.succeeded, self.failed, *self.failed_by, self.for_good):
            if item is not None:
                yield item

    @property
    def all_failed(self) -> tuple[State | None, ...]:
        """States after a Fail of the action, by its cause.

        The first is the state after causes that `Action.fail_endings` does not list; the others are those of
        the listed causes, in the list's order.
        """
        return (self.failed, *self.failed_by)


class StepMaker:
    """Maker of decisions by the rule, which takes the cheapest plan to the goal: for a state, it finds the
    next action.
    """

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
        """Return the first action of the cheapest plan from a state to the goal, with the states that may
        follow.

        Raises:
            TooMuch: the budget of search steps is spent.
        """
        planned = state.committed
        if not planned:
            segment = self._search.segment(state.situation, dict(state.fails))
            self._effort.spend(5 + 2 * self._search.steps)
            if segment is None:
                return Step(None)
            planned = tuple([action.index for action in segment.actions])
            if segment.hopes:
                planned = (*planned[:-1], ~planned[-1])
        self._effort.spend(5 + len(state.fails))
        return self._followed(planned, state.fails)

    def _followed(self, planned: tuple[int, ...], fails: Fails) -> Step:
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
    """Computation of the states of a run that follow the outcomes of an action.

    A state forgets the Fails of actions that the run can no longer start, so that there are fewer
    different states.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Compute what can follow each situation."""
        self._network, self._ahead = network, Ahead(network)
        self._bits = {
            counter: sum({self._ahead.bit(action.source) for action in actions})
            for counter, actions in network.shared.items()
        }
        parts: dict[int, dict[int, bool]] = {}
        self._kept = {name: parts.setdefault(self._ahead.bits(name), {}) for name in network.situations}
        """Answers of `matters` by counter, as far as they were asked for; situations of one strongly
        connected component share theirs.
        """

    def matters(self, situation: str, counter: int) -> bool:
        """Return whether runs from a situation can still start an action whose Fails a given counter counts.

        Args:
            situation: name of the situation.
            counter: number of the counter (`Action.counter`).
        """
        kept = self._kept[situation]
        found = kept.get(counter)
        if found is None:
            found = kept[counter] = bool(self._ahead.bits(situation) & self._bits[counter])
        return found

    def successes(
        self, action: Action, fails: Fails, committed: tuple[int, ...] = (), hopes: bool = False
    ) -> tuple[State | None, ...]:
        """Return the states after a Success, one for each situation that it may lead to.

        Args:
            action: the action.
            fails: Fails before the action, by counter (`Action.counter`), as in `State.fails`.
            committed: numbers of the actions that the plan has next if this action leads to its `target`.
            hopes: True if the plan counted on a Fail of the action; its Success then uses up an attempt.

        Returns:
            The state in `action.target`, then one for each of `action.others`; None for one of these whose
            probability is 0.
        """
        after = self._renewed(action, fails)
        if hopes:
            after = _counted(after, action.counter, action.allowance.failed(_count(after, action.counter)))
        kept = committed if after is fails else ()
        first = self._after(action, action.target, after, kept)
        if not action.others:
            return (first,)
        others = [
            None if other.p is not None and other.p <= _NEVER else self._after(action, other.target, after)
            for other in action.others
        ]
        return (first, *others)

    def fail(self, action: Action, fails: Fails, for_good: bool = False) -> State:
        """Return the state after a Fail of a cause that is not in `action.fail_endings`.

        Args:
            action: the action.
            fails: Fails before the action, by counter (`Action.counter`), as in `State.fails`.
            for_good: True for a Fail that uses up all attempts at once.
        """
        allowed, count = action.allowance, _count(fails, action.counter)
        after = allowed.used_up(count) if for_good else allowed.failed(count)
        return self._after(action, action.on_fail or action.source, _counted(fails, action.counter, after))

    def fails(self, action: Action, fails: Fails, happens: bool = True) -> list[State | None]:
        """Return the states after a Fail, one for each situation to which a Fail may lead.

        The first state is that after causes without an entry in `action.fail_endings`, followed by one for
        each entry.

        Args:
            action: the action.
            fails: Fails before the action, by counter (`Action.counter`), as in `State.fails`.
            happens: False if the action never fails: all states are then None.
        """
        endings = action.fail_endings
        if not happens:
            return [None] * (1 + len(endings))
        after = _failed_once_more(fails, action.counter, action.allowance)
        first = self._after(action, action.on_fail or action.source, after)
        if not endings:
            return [first]
        others = [self._after(action, ending.target or action.source, after) for ending in endings]
        return [first, *others]

    def at(self, situation: str, fails: Mapping[int, int]) -> State:
        """Return the state for planning in a situation, which is the situation and counts of Fails.

        Only Fails of actions that a run can still start from there are kept, because others cannot matter.

        Args:
            situation: the situation.
            fails: counts of Fails by counter.
        """
        if situation == self._network.goal:
            return State(situation, ())
        return State(situation, self._filtered(situation, sorted(fails.items())))

    def _after(self, action: Action, situation: str, fails: Fails, committed: tuple[int, ...] = ()) -> State:
        """Return the state in a situation that an action leads to.

        Args:
            action: the action.
            situation: the situation.
            fails: all Fails, sorted by their counters.
            committed: the actions that the plan prescribes next, as in `State`.
        """
        if situation == self._network.goal:
            return State(situation, ())
        if fails and self._kept[situation] is not self._kept[action.source]:
            fails = self._filtered(situation, fails)
        return State(situation, fails, committed)

    def _filtered(self, situation: str, fails: Sequence[tuple[int, int]]) -> Fails:
        known = self._kept[situation]
        try:
            return tuple([item for item in fails if known[item[0]]])
        except KeyError:
            return tuple([item for item in fails if self.matters(situation, item[0])])

    def _renewed(self, action: Action, fails: Fails) -> Fails:
        counters = self._network.renewed_by.get(action.index)
        if not counters or not fails:
            return fails
        actions, after = self._network.actions, fails
        for counter, count in fails:
            if counter in counters and (new := actions[counter].allowance.renewed(count)) != count:
                after = _counted(after, counter, new)
        return after


def _count(fails: Fails, counter: int) -> int:
    place = bisect_left(fails, (counter, 0))
    return fails[place][1] if place < len(fails) and fails[place][0] == counter else 0


def _failed_once_more(fails: Fails, counter: int, allowed: Attempts) -> Fails:
    """Return the Fails after one more of a counter."""
    place = bisect_left(fails, (counter, 0))
    if place < len(fails) and fails[place][0] == counter:
        return (*fails[:place], (counter, allowed.failed(fails[place][1])), *fails[place + 1 :])
    return (*fails[:place], (counter, allowed.failed(0)), *fails[place:])


def _counted(fails: Fails, counter: int, count: int) -> Fails:
    """Return the Fails with another count; the others are shared, because there are thousands of states."""
    place = bisect_left(fails, (counter, 0))
    rest = place + (place < len(fails) and fails[place][0] == counter)
    return (*fails[:place], (counter, count), *fails[rest:])
