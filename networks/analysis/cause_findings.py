"""Findings on the causes in `on_fail` that no Fail of the action has; actions that fail into a situation."""

from __future__ import annotations

from collections.abc import Iterator

from handcart.files.errors import Finding
from handcart.files.suggest import suggest
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.task.task_file import Task
from handcart.primitives.contract.raised_causes import possible_causes


def cause_findings(task: Task) -> Iterator[Finding]:
    """Yield a finding for each cause that an action's `on_fail` names, but that the action's primitive never
    gives.
    """
    kinds = {
        number: action.binding.kind
        for number, action in zip(task.entries, task.network.actions, strict=True)
        if number is not None and action.binding is not None
    }
    for number, entry in enumerate(task.file.actions):
        if number not in kinds or not entry.fail_entries:
            continue
        possible = [possible_cause.name for possible_cause in possible_causes(kinds[number])]
        for cause in entry.fail_entries:
            if cause not in possible:
                wrong = f"no Fail of {entry.do} has the cause {cause!r}{suggest(cause, possible)}"
                yield task.document.finding(("actions", number, "on_fail", cause), wrong)


def causes_into(network: ActionNetwork, situation: str) -> list[str]:
    """Return the actions whose Fail by a named cause leads to a situation, each as "ACTION by 'CAUSE'"."""
    found = {
        f"{action.do} by {ending.cause!r}"
        for action in network.actions
        for ending in action.fail_endings
        if ending.target == situation
    }
    return sorted(found)
