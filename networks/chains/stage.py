"""A piece of a network that can be computed alone."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from handcart.networks.graph.network import MAX_ATTEMPTS, Action, ActionNetwork


@dataclass(frozen=True)
class Stage:
    """A piece of a network that each successful run passes exactly once.

    Every run that reaches the goal of the whole network enters the piece at its start, leaves it at its
    goal, and never returns.
    """

    network: ActionNetwork
    numbers: tuple[int, ...]
    """Number of each of its actions in the whole network."""

    @cached_property
    def shape(self) -> tuple[object, ...]:
        """All data that planning in this part of the network depends on, without names.

        The data are equal for copies of a part that the task repeats for equal elements of a list.
        """
        place = {name: number for number, name in enumerate(self.network.situations)}
        rows = tuple(
            (
                place[a.source],
                place[a.target],
                None if a.on_fail is None else place[a.on_fail],
                a.cost_s,
                a.attempts,
                a.binding is None,
                *self._more(a, place),
            )
            for a in self.network.actions
        )
        return place[self.network.start], place[self.network.goal], rows

    def _more(self, a: Action, place: Mapping[str, int]) -> tuple[object, ...]:
        """Return further data that planning with an action depends on: results, shared attempts and
        renewals.
        """
        others = tuple((place[other.target], other.p) for other in a.others)
        p = a.p if a.others else None
        counts = a.counter, a.unlimited, a.renewals, self.network.renewed_by.get(a.index, ())
        fails = tuple((None if e.target is None else place[e.target], e.p) for e in a.fail_endings)
        return *counts, others, p, fails, (a.p_success, a.p_give_up) if fails else ()

    def with_one_more(self, numbers: Collection[int]) -> Stage:
        """Return this piece of the network with one more attempt for some actions, and for those that share
        attempts with them.

        Args:
            numbers: numbers of the actions in the complete network.
        """
        pairs = zip(self.network.actions, self.numbers, strict=True)
        counters = {action.counter for action, number in pairs if number in numbers}
        actions = [
            replace(action, attempts=min(MAX_ATTEMPTS, action.attempts + 1))
            if number in numbers or action.counter in counters
            else action
            for action, number in zip(self.network.actions, self.numbers, strict=True)
        ]
        return self._with(actions, self.numbers)

    def with_alternatives(self, numbers: Collection[int]) -> Stage:
        """Return the stage (part of a network) with some actions doubled: a second, equal action is added
        between the same situations.

        Args:
            numbers: numbers of the actions to be doubled, in the complete network.
        """
        pairs = list(zip(self.network.actions, self.numbers, strict=True))
        pairs += [pair for pair in pairs if pair[1] in numbers]
        return self._with([action for action, _ in pairs], tuple(number for _, number in pairs))

    def _with(self, actions: Sequence[Action], numbers: tuple[int, ...]) -> Stage:
        whole = self.network
        network = ActionNetwork.build(whole.situations.values(), actions, whole.start, whole.goal)
        return Stage(network, numbers)
