"""Several goals in order: the network once for each goal, one after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from handcart.networks.graph.network import MAX_ACTIONS

from .copied import Copied, Copies


class TooManyGoals(ValueError):
    """Error, because the network would be too large; the message says why."""


def goal_copy(name: str, number: int) -> str:
    """Return the name of a situation's copy in the part of the network that leads to a goal.

    Args:
        name: name of the situation.
        number: number of the goal in the task's order, from 0; copies for goal 0 keep the plain name.
    """
    return name if number == 0 else f"{name} (goal {number + 1})"


def goals_in_order(network: Copies, goals: Sequence[str]) -> Copies:
    """Return a network that reaches several goals one after the other, with a copy of `network` for each.

    Args:
        network: the network to copy.
        goals: situations of `network` to be reached, in this order.

    Raises:
        TooManyGoals: the new network would have more than `MAX_ACTIONS` actions.
    """
    count = len(network.actions) * len(goals)
    if count > MAX_ACTIONS:
        raise TooManyGoals(f"with its goals the network has {count} actions; allowed: at most {MAX_ACTIONS}")
    situations = {
        goal_copy(name, number): origin
        for number in range(len(goals))
        for name, origin in network.situations.items()
    }
    actions = tuple(
        copied for number in range(len(goals)) for copied in _actions(network.actions, goals, number)
    )
    return Copies(situations, actions, network.start)


def _actions(actions: Sequence[Copied], goals: Sequence[str], number: int) -> Iterator[Copied]:
    def led(name: str) -> str:
        is_reached = name == goals[number] and number + 1 < len(goals)
        return goal_copy(name, number + is_reached)

    for action in actions:
        if action.source == goals[number] and number + 1 == len(goals):
            continue  # the run is over
        yield replace(
            action,
            source=goal_copy(action.source, number),
            target=led(action.target),
            on_fail=action.on_fail and led(action.on_fail),
            others=tuple(map(led, action.others)),
            fails=tuple(name and led(name) for name in action.fails),
        )
