"""Findings on a task's network, each with its place in the file and a path as a counter-example."""

from __future__ import annotations

import re
from collections.abc import Collection

import networkx as nx

from handcart.files.errors import Finding
from handcart.networks.graph.ahead import ways_of
from handcart.networks.graph.network import Action
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import ConditionFile

from .aim_findings import aim_findings
from .cause_findings import cause_findings, causes_into
from .condition_findings import condition_findings
from .fact_findings import fact_findings
from .hand_findings import denied_hand_facts
from .worst_cases import WorstCases


def task_findings(task: Task) -> list[Finding]:
    """Return findings on the doubtful parts of a task's network.

    Doubtful are situations that no run reaches or from which nothing leads on, causes that a primitive never
    gives, interrupts without a route, changes of facts that do not suit an action's primitive, and facts that
    contradict the hand's content after an action.
    """
    facts = [*fact_findings(task), *denied_hand_facts(task)]
    ends = condition_findings(task) if isinstance(task.file, ConditionFile) else _dead_ends(task)
    return [*_unreached(task), *ends, *cause_findings(task), *aim_findings(task), *facts]


def _unreached(task: Task) -> list[Finding]:
    network, graph = task.network, ways_of(task.network)
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
    network, graph = task.network, ways_of(task.network)
    leads_on = _leading_to(graph, (network.goal, *network.otherwise))
    reached = nx.descendants(graph, network.start) | {network.start}
    on = reached & leads_on
    failed_into = {to for action in network.actions if action.source in on for to in action.leads_to[1:]}
    found: dict[str, Finding] = {}
    for name in network.situations:
        if name not in reached or name in leads_on or name in network.otherwise:
            continue
        way = " to ".join(nx.shortest_path(graph, network.start, name))
        if name in failed_into:
            failed = " or ".join(causes_into(network, name))
            after = f", after a Fail of {failed}," if failed else ""
            words = f"a run that comes there ({way}){after} ends with status 3; allowed, if that is meant"
        else:
            words = f"no plan leads there ({way}); needed: an action that leads on from it, or leave it out"
        plain = plain_name(task, name)
        message = f"from {plain!r} nothing leads to the goal: {words}"
        found.setdefault(plain, task.document.finding(("situations", plain), message))
    return list(found.values())


def _leading_to(graph: nx.MultiDiGraph, goals: Collection[str]) -> set[str]:
    """Return the situations from which actions lead to one of some goals, and these goals."""
    return {name for goal in goals for name in (goal, *nx.ancestors(graph, goal))}


def unused_findings(task: Task, cases: WorstCases, best: Collection[int] | None = None) -> list[Finding]:
    """Return findings on actions that no run ever plans, although a run could reach their situation.

    Only actions from which the goal can be reached are considered.

    Actions on routes to situations listed as `otherwise` are not reported, because a run pursues these
    situations if no route to the goal is left.

    Args:
        task: the task.
        cases: worst cases of the task's network, if the coordinator takes the cheapest routes.
        best: numbers of the actions that the best policy takes; None if that policy is not known.
    """
    network, graph = task.network, ways_of(task.network)
    leads_on = _leading_to(graph, (network.goal,)) - _leading_to(graph, network.otherwise)
    reached = nx.descendants(graph, network.start) | {network.start}
    unused = {action.index for action in cases.unused}
    found = []
    every: dict[int | None, list[Action]] = {}
    for action, number in zip(network.actions, task.entries, strict=True):
        every.setdefault(number, []).append(action)
    for number, entry in enumerate(task.file.actions):
        copies = every.get(number, [])
        asked = [a for a in copies if a.source in reached and not leads_on.isdisjoint(a.leads_to)]
        if asked and all(action.index in unused for action in copies):
            better = [] if best is None else [a for a in copies if a.index in best]
            words = f"no run ever does {entry.do} from {entry.source!r}, whatever fails"
            if better:
                allowed = "the best policy does it; needed: policy: expected_cost, or a lower cost_s"
            elif best is None:
                allowed = "needed: a lower cost_s, or p for each action, to know whether it is worth while"
            else:
                allowed = "neither does the best policy; needed: a lower cost_s, or leave it out"
            found.append(task.document.finding(("actions", number), f"{words}; {allowed}"))
    return found


def short_findings(task: Task, cases: WorstCases) -> list[Finding]:
    """Return a finding for each situation in which a run can end short of the goal.

    The finding's place in the task's file is the last action that Fails on the shortest path of a run to this
    situation.
    """
    found: dict[str, Finding] = {}
    for item in cases.short:
        situation = plain_name(task, item.situation)
        last = next((action.index for action, failed in reversed(item.path) if failed), None)
        entry = None if last is None else task.entries[last]
        key = ("situations", situation) if entry is None else ("actions", entry)
        path = item.words(lambda name: plain_name(task, name)) or "none leads there from the start"
        message = f"in {situation!r} no way may be left: {path}"
        found.setdefault(situation, task.document.finding(key, message))
    return list(found.values())


def plain_name(task: Task, name: str) -> str:
    """Return a situation's name as written in the file, without the ending that a copy by `repeat` has."""
    return name if task.network.situations[name].element is None else re.sub(r"(\[\d+\])+$", "", name)
