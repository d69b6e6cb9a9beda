"""A piece of a network that can be computed alone."""

from __future__ import annotations

from collections.abc import Collection, Sequence
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
        """All that planning in it depends on, without names: the copies of a `repeat` have equal ones."""
        place = {name: number for number, name in enumerate(self.network.situations)}
        rows = tuple(
            (
                place[a.source],
                place[a.target],
                None if a.on_fail is None else place[a.on_fail],
                a.cost_s,
                a.attempts,
                a.binding is None,
            )
            for a in self.network.actions
        )
        return place[self.network.start], place[self.network.goal], rows

    def with_one_more(self, numbers: Collection[int]) -> Stage:
        """Return the stage with one more attempt of those actions, given by their numbers in the whole."""
        actions = [
            replace(action, attempts=min(MAX_ATTEMPTS, action.attempts + 1)) if number in numbers else action
            for action, number in zip(self.network.actions, self.numbers, strict=True)
        ]
        return self._with(actions, self.numbers)

    def with_alternatives(self, numbers: Collection[int]) -> Stage:
        """Return the stage with a second, equal action next to each of those."""
        pairs = list(zip(self.network.actions, self.numbers, strict=True))
        pairs += [pair for pair in pairs if pair[1] in numbers]
        return self._with([action for action, _ in pairs], tuple(number for _, number in pairs))

    def _with(self, actions: Sequence[Action], numbers: tuple[int, ...]) -> Stage:
        whole = self.network
        network = ActionNetwork.build(whole.situations.values(), actions, whole.start, whole.goal)
        return Stage(network, numbers)
