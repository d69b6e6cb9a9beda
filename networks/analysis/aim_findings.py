"""Findings on interrupts: routes that are missing to their goals, or from there to the task's goal."""

from __future__ import annotations

from collections.abc import Iterator

import networkx as nx

from handcart.files.errors import Finding
from handcart.networks.graph.ahead import ways_of
from handcart.networks.task.task_file import Task


def aim_findings(task: Task) -> Iterator[Finding]:
    """Yield findings on interrupts whose goal cannot be reached from some situation, or from whose goal no
    route leads on to the task's goal.

    An interrupt is a goal that comes before the task's goal when a condition holds, such as a low battery.
    """
    network, graph = task.network, ways_of(task.network)
    reached = nx.descendants(graph, network.start) | {network.start}
    leads_on = nx.ancestors(graph, network.goal) | {network.goal}
    for number, interrupt in enumerate(network.aims.interrupts):
        goals = [name for name in interrupt.goals if name in graph]
        before = set(goals).union(*(nx.ancestors(graph, name) for name in goals))
        without = [name for name in network.situations if name in reached & leads_on - before]
        without = [name for name in without if name != network.goal]
        path = ("interrupts", number, "goal")
        if without:
            where = f"{without[0]!r}" + (f" and {len(without) - 1} more" if len(without) > 1 else "")
            words = f"{interrupt.name}: no route leads there from {where}; it is left out there"
            yield task.document.finding(path, f"{words}, if that is meant")
        stuck = [name for name in goals if name in reached and name not in leads_on]
        if stuck:
            words = f"{interrupt.name}: from {stuck[0]!r} nothing leads on to the goal"
            yield task.document.finding(path, f"{words}; needed: an action that leads on from it")
