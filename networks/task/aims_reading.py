"""Reading of several goals, rounds and interrupts of a written network, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from handcart.files.suggest import listed, suggest
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.entries.aims_entry import SituationInterrupt
from handcart.networks.entries.copied import Copies
from handcart.networks.entries.goals_in_order import TooManyGoals, goal_copy, goals_in_order
from handcart.networks.graph.aims import Aims
from handcart.networks.graph.network import ActionNetwork

Fault = tuple[KeyPath, str]
"""Position in the task's document, and the fault with the allowed values."""


def goal_faults(
    names: Sequence[str], is_listed: bool, start: str, situations: Mapping[str, object]
) -> Iterator[Fault]:
    """Yield a fault for each goal of a task file that is no situation of the file, or is reached already.

    Args:
        names: the goals, in order.
        is_listed: whether the file has them as a list; a fault then names the goal's position in the list.
        start: the situation at the start.
        situations: the file's situations, by name.
    """
    before = start if len(names) > 1 else ""
    for number, name in enumerate(names):
        path: KeyPath = ("goal", number) if is_listed else ("goal",)
        if situations and name not in situations:
            yield path, f"unknown situation {name!r}{suggest(name, situations)}"
        elif name == before:
            yield path, f"{name!r} is reached already; allowed: another situation than the one before it"
        before = name


def interrupt_faults(
    entries: Sequence[SituationInterrupt], situations: Mapping[str, object]
) -> Iterator[Fault]:
    """Yield a fault for each interrupt (detour when a condition holds) whose goal is not a situation of the
    task's file.
    """
    for number, entry in enumerate(entries):
        if situations and entry.goal not in situations:
            wrong = f"unknown situation {entry.goal!r}{suggest(entry.goal, situations)}"
            yield ("interrupts", number, "goal"), wrong


def in_order(network: Copies, goals: Sequence[str]) -> tuple[Copies, str]:
    """Return a network that reaches several goals one after the other, and the name of its last goal.

    Raises:
        TooManyGoals: a goal is within a repeated part, or the network would be too large.
    """
    inside = [name for name in goals if name not in network.situations]
    if inside:
        raise TooManyGoals(f"{listed(inside)} is inside a repeated part; allowed: a situation outside of it")
    if len(goals) == 1:
        return network, goals[0]
    return goals_in_order(network, goals), goal_copy(goals[-1], len(goals) - 1)


def goal_copies(network: Copies, name: str) -> tuple[str, ...]:
    """Return the names of all situations in the network that are copies of one situation of the task's file.

    A task that repeats actions for each element of a list has a copy for each element.
    """
    return tuple(copy for copy, (called, _) in network.situations.items() if called == name)


def round_faults(network: ActionNetwork) -> Iterator[Fault]:
    """Yield a fault if a task that is repeated in rounds has a goal with other facts than its start."""
    start, goal = (network.situations[name] for name in (network.start, network.goal))
    if network.aims.rounds is not None and dict(start.facts) != dict(goal.facts):
        differing = [name for name in start.facts if start.facts[name] != goal.facts.get(name)]
        wrong = f"the goal {goal.name!r} has other facts than the start {start.name!r}"
        which = f" ({listed(differing)})" if differing else ""
        yield ("rounds",), f"{wrong}{which}; allowed: a goal where another round can begin"


def battery_faults(aims: Aims) -> Iterator[Fault]:
    """Yield a fault for each interrupt (goal that a run pursues before the task's goal) that depends on the
    charge of the battery; for robots that do not measure the charge.
    """
    for number, interrupt in enumerate(aims.interrupts):
        if interrupt.battery_below is not None:
            wrong = "the robot measures no charge of its battery"
            allowed = "allowed: every_s, or a robot with a sensor of the kind battery"
            yield ("interrupts", number, "when", "battery_below_percent"), f"{wrong}; {allowed}"
