"""How runs of a task end, on which action most depends, and what one more attempt would buy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from networks.network import MAX_ATTEMPTS, ActionNetwork
from networks.task_file import Task

from .forecast import Chance, Forecast, forecast

ASSUMPTION = "attempts are independent of each other, and no Fail is for good"
_STEP = 1e-4


@dataclass(frozen=True)
class Influence:
    """What an action of the file means for the whole."""

    entry: int
    """Its number in the file."""
    words: str
    slope: float
    """By how much P(goal) grows with its probability of Success."""
    one_more: Forecast
    """What one more attempt of it would give."""


@dataclass(frozen=True)
class Figures:
    """How runs of a task end."""

    forecast: Forecast
    influences: tuple[Influence, ...]
    """The action first on which P(goal) depends most."""

    def for_programs(self) -> dict[str, Any]:
        """What `handcart check --json` gives."""
        now = self.forecast
        return {
            "p_goal": now.goal,
            "p_no_way": now.no_way,
            "p_give_up": now.give_up,
            "cost_s": now.cost_s,
            "cost_sigma_s": now.cost_sigma_s,
            "assumption": ASSUMPTION,
            "actions": [
                {
                    "action": each.words,
                    "slope": each.slope,
                    "one_more_p_goal": each.one_more.goal,
                    "one_more_cost_s": each.one_more.cost_s,
                }
                for each in self.influences
            ],
        }


def missing_chances(task: Task) -> list[int]:
    """Numbers in the file of the actions without a probability `p`."""
    return [number for number, entry in enumerate(task.file.actions) if entry.p is None]


def figures(task: Task) -> Figures:
    """The figures of a task whose actions all have a probability `p`.

    Raises:
        TooLarge: its network has too many states for exact figures.
    """
    known = {number: Chance(each.p or 0.0, each.p_give_up) for number, each in enumerate(task.file.actions)}
    now = forecast(task.network, _chances(task, known))
    influences = []
    for number in known:
        part = next((a for a, e in zip(task.network.actions, task.entries, strict=True) if e == number), None)
        if part is None:
            continue
        slope = (_with(task, known, number, _STEP) - _with(task, known, number, -_STEP)) / (2.0 * _STEP)
        more = forecast(_one_more(task, number), _chances(task, known))
        influences.append(Influence(number, str(part), slope, more))
    influences.sort(key=lambda each: -each.slope)
    return Figures(now, tuple(influences))


def _with(task: Task, known: dict[int, Chance], number: int, step: float) -> float:
    """P(goal) with another probability of one action; the model is smooth beyond 1, too."""
    chance = known[number]
    moved = Chance(chance.success + step, chance.give_up)
    return forecast(task.network, _chances(task, {**known, number: moved})).goal


def _chances(task: Task, known: dict[int, Chance]) -> Sequence[Chance | None]:
    return [None if entry is None else known[entry] for entry in task.entries]


def _one_more(task: Task, number: int) -> ActionNetwork:
    network = task.network
    actions = tuple(
        replace(action, attempts=min(MAX_ATTEMPTS, action.attempts + 1)) if entry == number else action
        for action, entry in zip(network.actions, task.entries, strict=True)
    )
    return replace(network, actions=actions)
