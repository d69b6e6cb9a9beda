"""What is doubtful about a task's network: each finding with its place, a counter-example as a path."""

from __future__ import annotations

import networkx as nx

from backends.arm import Arm
from backends.base import Base
from backends.gripper import Gripper
from files.errors import Finding
from networks.network import Action
from networks.task_file import Task

_MOVED_BY = {"base": (Base,), "hand": (Arm, Gripper)}
"""Facts that only some capabilities can change, by the names that tasks use for them."""


def task_findings(task: Task) -> list[Finding]:
    """Situations that no run comes to, situations from which nothing leads on, facts that can't change so."""
    return [*_unreached(task), *_dead_ends(task), *_facts(task)]


def _with_fails(task: Task) -> nx.DiGraph[str]:
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(task.network.situations)
    for action in task.network.actions:
        graph.add_edge(action.source, action.target)
        if action.on_fail is not None:
            graph.add_edge(action.source, action.on_fail)
    return graph


def _unreached(task: Task) -> list[Finding]:
    network, graph = task.network, _with_fails(task)
    reached = nx.descendants(graph, network.start) | {network.start}
    return [
        task.document.finding(
            ("situations", name),
            f"no run comes to {name!r}; allowed: an action that leads there, or leave it out",
        )
        for name, situation in network.situations.items()
        if name not in reached and situation.element is None
    ]


def _dead_ends(task: Task) -> list[Finding]:
    network, graph = task.network, _with_fails(task)
    leads_on = nx.ancestors(network.graph, network.goal) | {network.goal}
    reached = nx.descendants(graph, network.start) | {network.start}
    found = []
    for name in network.situations:
        if name in reached and name not in leads_on and network.situations[name].element is None:
            way = " to ".join(nx.shortest_path(graph, network.start, name))
            words = (
                f"from {name!r} nothing leads to the goal: a run that comes there ({way}) ends with status 3"
            )
            found.append(task.document.finding(("situations", name), f"{words}; allowed, if that is meant"))
    return found


def _facts(task: Task) -> list[Finding]:
    found = []
    told = set()
    for action, entry in zip(task.network.actions, task.entries, strict=True):
        if action.binding is None or entry is None or entry in told:
            continue
        for name, parts in _MOVED_BY.items():
            change = _change(task, action, name)
            if change and not set(parts) & set(action.binding.kind.needs):
                told.add(entry)
                able = " or ".join(each.__name__ for each in parts)
                words = f"{action.do} moves no {able}, but {name!r} goes from {change[0]} to {change[1]}"
                place = ("actions", entry, "to")
                found.append(task.document.finding(place, f"{words}; allowed: situations that agree in it"))
    return found


def _change(task: Task, action: Action, fact: str) -> tuple[object, object] | None:
    facts = [task.network.situations[name].facts for name in (action.source, action.target)]
    if all(fact in each for each in facts) and facts[0][fact] != facts[1][fact]:
        return facts[0][fact], facts[1][fact]
    return None
