"""Trials of the action network alone: how an action ends is drawn by its probabilities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from random import Random
from typing import Any

from handcart.files.errors import FileError
from handcart.networks.analysis.figures import missing_chances
from handcart.networks.graph.planner import NoWay, Route
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.contract.outcome import Success

from .action_ends import names_in_network
from .trial import ActionEnd, Trial

DRAWN = "drawn by its probability"


@dataclass(frozen=True)
class NetworkTrials:
    """Trials of one task, in no world; attempts are independent of each other, and no Fail is for good."""

    task: Task
    _names: Mapping[int, str] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Raise `FileError` where an action has no probability `p`."""
        document = self.task.document
        wrong = "no probability `p`; needed: one for each action, to draw how it ends"
        missing = missing_chances(self.task)
        if missing:
            raise FileError(document.finding(("actions", number), wrong) for number in missing)
        object.__setattr__(self, "_names", names_in_network(self.task))

    def trial(self, seed: int) -> Trial:
        """Go through the network as the coordinator would."""
        route, draw = Route(self.task.network), Random(seed).random
        ends: list[ActionEnd] = []
        skipped, time, fails, replans = False, 0.0, 0, -1
        outcome, status, reason = "Success", 0, ""
        while not route.arrived:
            if not route.planned:
                replans += 1
                plan = route.plan()
                if isinstance(plan, NoWay):
                    outcome, status, reason = "Fail", 3, plan.explanation
                    break
            action = route.next
            entry = self.task.entries[action.index]
            if entry is None:
                skipped = True
                route.took(Success())
                continue
            chance, drawn = self.task.file.actions[entry], draw()
            time += action.cost_s
            names = self._names[action.index], action.source, action.target
            if drawn < (chance.p or 0.0):
                ends.append(ActionEnd(*names, "Success", time))
                route.took(Success())
                continue
            fails += 1
            if drawn >= 1.0 - chance.p_give_up:
                ends.append(ActionEnd(*names, "GiveUp", time, DRAWN))
                outcome, status, reason = "GiveUp", 4, f"{action}: {DRAWN}"
                break
            ends.append(ActionEnd(*names, "Fail", time, DRAWN))
            route.failed(DRAWN)
        if skipped and not status:
            outcome, status, reason = "Fail", 3, "elements were left undone"
        summary: dict[str, Any] = {"outcome": outcome, "situation": route.situation, "reason": reason}
        summary |= {"actions": len(ends), "fails": fails, "replans": max(0, replans), "sim_time_s": time}
        return Trial(seed, status, {**summary, "seed": seed, "run_dir": "", "metrics": {}}, ends)


def network_trials(task: Path, settings: Mapping[str, str]) -> NetworkTrials:
    """The trials of a task's file, which is read once as long as it doesn't change; raises `FileError`."""
    changed = task.stat().st_mtime_ns if task.exists() else 0
    return _read(task, tuple(settings.items()), changed)


@lru_cache(maxsize=4)
def _read(task: Path, settings: tuple[tuple[str, str], ...], changed: int) -> NetworkTrials:
    return NetworkTrials(load_task(task, dict(settings)))
