"""Observer that records how each action of a trial ended."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.graph.network import Action
from handcart.networks.task.task_file import Task
from handcart.primitives.outcomes.outcome import Fail, Success

from .trial import ActionEnd

if TYPE_CHECKING:
    from handcart.networks.task.preparing import Prepared


class ActionEnds(RunObserver):
    """Observer of a trial that records the outcome, time and reason of each action that ends."""

    def __init__(self) -> None:
        """Begin with an empty record."""
        self.ends: list[ActionEnd] = []
        self._names: dict[int, str] = {}

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Look up the names of the actions in the task's file."""
        self._names = names_in_network(prepared.task)

    def event(self, event: Event) -> None:
        """Record the outcome of an action if the event is the end of one; ignore other events."""
        if not isinstance(event, Ended):
            return
        action, outcome, causes = event.action, event.outcome, event.primitive.evidence.causes
        reason = "" if isinstance(outcome, Success) else outcome.reason
        check = causes[-1].check if reason and causes else ""
        ends = action.source, action.target, type(outcome).__name__
        for_good = isinstance(outcome, Fail) and outcome.permanent
        cause = outcome.cause.name if reason and not isinstance(outcome, Success) else ""
        result = outcome.result if isinstance(outcome, Success) else None
        row = self._name(action), *ends, round(event.time, 6), reason, check, for_good, cause, result
        self.ends.append(ActionEnd(*row))

    def _name(self, action: Action) -> str:
        return self._names.get(action.index, f"{action.do} ({action.source} to {action.target})")


def action_names(task: Task) -> list[str]:
    """Return a unique name for each action of a task's file, such as `MOVE_TO (here to there)`.

    Repeated names get a number: `MOVE_TO (here to there) #2`.
    """
    plain = [f"{action.do} ({action.source} to {action.target})" for action in task.file.actions]
    seen: Counter[str] = Counter()
    names = []
    for name in plain:
        seen[name] += 1
        names.append(name if seen[name] == 1 else f"{name} #{seen[name]}")
    return names


def names_in_network(task: Task) -> dict[int, str]:
    """Return the names of a task's actions by their numbers in its network.

    The network also has actions that skip one element of a repeated part of the task. They are not in the
    task's file and have no name.
    """
    names = action_names(task)
    return {number: names[entry] for number, entry in enumerate(task.entries) if entry is not None}
