"""Checks that the facts of a task's situations fit its actions, each finding with its place in the file."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.files.errors import Finding
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import ConditionFile

_MOVED_BY = {"base": (Base,), "hand": (Arm, Gripper)}
"""Facts that only some capabilities can change, by the names that tasks use for them."""

Changes = Mapping[str, tuple[object, object]]
"""Changes that an action makes: the fact's name, mapped to its value before and after."""


def fact_findings(task: Task) -> list[Finding]:
    """Return findings on changes of facts by Success that do not suit the action's primitive.

    Either the primitive cannot change the fact, or another action of the task with this primitive does not
    change it. A Fail that would change facts is rejected already when the file is read.
    """
    actions = dict(reversed([(e, a) for a, e in zip(task.network.actions, task.entries, strict=True)]))
    found = []
    for entry in range(len(task.file.actions)):
        binding = actions[entry].binding if entry in actions else None
        if binding is None:
            continue
        changes = _changes(task, entry)
        unable = {
            name: " or ".join(part.__name__ for part in parts)
            for name, parts in _MOVED_BY.items()
            if name in changes and not set(parts) & set(binding.kind.needs)
        }
        for name, (before, after) in changes.items():
            if name in unable:
                words = f"{binding.label} moves no {unable[name]}, but {name!r} goes from {before} to {after}"
            elif binding.kind.only_knowledge:
                words = (
                    f"{binding.label} only changes what is known, but {name!r} goes from {before} to {after}"
                )
            else:
                continue
            allowed = "allowed: situations that agree in it"
            found.append(task.document.finding(("actions", entry, "to"), f"{words}; {allowed}"))
    return [*found, *_more_than_elsewhere(task)]


def _more_than_elsewhere(task: Task) -> list[Finding]:
    """Return findings on actions that change one fact more than the same primitive does elsewhere.

    The primitive that would change the extra fact is probably missing.
    """
    entries = list(enumerate(task.file.actions))
    changes = {number: each for number, _ in entries if (each := _changes(task, number))}
    first: dict[tuple[str, frozenset[str]], int] = {}
    for number in changes:
        first.setdefault((task.file.actions[number].do, frozenset(changes[number])), number)
    found = []
    for number, here in changes.items():
        entry = task.file.actions[number]
        for (do, there), other in first.items():
            if do != entry.do or not there < here.keys():
                continue
            more = ", ".join(repr(name) for name in here if name not in there)
            line = task.document.position(("actions", other))[0]
            words = f"{entry.do} also changes {more} here, which it doesn't in line {line}"
            needed = "needed: an action that does it, between them or in place of this one"
            found.append(task.document.finding(("actions", number, "to"), f"{words}; {needed}"))
            break
    return found


def _changes(task: Task, number: int) -> Changes:
    """Return the changes of an action of the file, among the facts that both of its situations state."""
    if isinstance(task.file, ConditionFile):
        return _conditional_changes(task.file, number)
    entry, situations = task.file.actions[number], task.file.situations
    before, after = situations.get(entry.source) or {}, situations.get(entry.target) or {}
    both = (name for name in before if name in after)
    return {name: (before[name], after[name]) for name in both if before[name] != after[name]}


def _conditional_changes(file: ConditionFile, number: int) -> Changes:
    """Return the changes of physical facts by an action that is given with conditions."""
    entry = file.actions[number]
    changed = {name: value for name, value in entry.endings[0].changes.items() if name in file.facts}
    before = {name: entry.condition.get(name) for name in changed}
    return {name: (before[name], value) for name, value in changed.items() if before[name] != value}
