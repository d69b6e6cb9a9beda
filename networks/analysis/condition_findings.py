"""Findings on a network that was generated from conditions: impossible actions, and dead ends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import networkx as nx

from handcart.files.errors import Finding
from handcart.networks.entries.condition_entry import value_in_words
from handcart.networks.graph.ahead import ways_of
from handcart.networks.graph.network import Fact
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import ConditionFile


def condition_findings(task: Task) -> list[Finding]:
    """Return findings on a task that is written as conditions on facts.

    They name actions that never start, conditions for values that a fact never has, and situations from which
    nothing leads to the goal.
    """
    assert isinstance(task.file, ConditionFile)
    return [*_never_started(task), *_never_true(task, task.file), *_dead_ends(task)]


def _never_started(task: Task) -> Iterator[Finding]:
    used = set(task.entries)
    for number, entry in enumerate(task.file.actions):
        if number not in used:
            wrong = f"no run comes to a situation in which {entry.do} changes something ({entry.source})"
            allowed = "allowed: other conditions, or leave it out"
            yield task.document.finding(("actions", number, "if"), f"{wrong}; {allowed}")


def _never_true(task: Task, file: ConditionFile) -> Iterator[Finding]:
    """Yield the values of facts that neither hold at the start nor follow from an action of the network."""
    effects: dict[str, set[tuple[bool, Fact]]] = {}
    for name, value in _effects(task, file):
        effects.setdefault(name, set()).add((isinstance(value, bool), value))
    for key, facts in (("facts", file.facts), ("known", file.known)):
        for name, values in facts.items():
            first = file.start.get(name, values[0])
            true = {(isinstance(first, bool), first), *effects.get(name, ())}
            for number, value in enumerate(values):
                if (isinstance(value, bool), value) not in true:
                    wrong = f"{name} is never {value_in_words(value)!r} in any run"
                    allowed = "allowed: an action that leads there, or leave it out"
                    yield task.document.finding((key, name, number), f"{wrong}; {allowed}")


def _effects(task: Task, file: ConditionFile) -> Iterator[tuple[str, Fact]]:
    for number in {entry for entry in task.entries if entry is not None}:
        entry = file.actions[number]
        every: list[Mapping[str, Fact]] = [ending.changes for ending in entry.endings]
        for effects in [*every, *(fail.known for fail in entry.fails.values())]:
            yield from effects.items()


def _dead_ends(task: Task) -> Iterator[Finding]:
    """Yield one finding on all situations from which nothing leads to the goal, with the shortest route."""
    network, graph = task.network, ways_of(task.network)
    leads_on = nx.ancestors(graph, network.goal) | {network.goal}
    ends = [name for name in network.situations if name not in leads_on]
    if ends:
        routes = nx.single_source_shortest_path(graph, network.start)
        route: list[str] = min((routes[name] for name in ends if name in routes), key=len, default=[])
        many = f"from {len(ends)} situations nothing leads to the goal"
        words = f"{many}, such as {ends[0]!r} ({' to '.join(route)}); allowed, if that is meant"
        yield task.document.finding(("goal",), words)
