"""An imagined run: outcomes come from a file, or all are Success."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.networks.deciding.planners import planner_of
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import NoWay
from handcart.networks.graph.route import RunDecisions
from handcart.primitives.outcomes.outcome import Success

Word = Literal["Success", "Fail", "FailForGood", "GiveUp"]


class WithResult(FileModel):
    """Scripted outcome Success with a given result, for a primitive that has several results."""

    success: Annotated[str, Field(alias="Success")]
    """The result, as an entry of `then` names it."""


class Script(FileModel):
    """Scripted outcomes for the actions of a run, in order; actions after the last outcome succeed."""

    format: Literal["handcart-script/1"]
    outcomes: Annotated[list[Word | WithResult], Field(max_length=10_000)]
    """Outcomes in order; `FailForGood` uses up all attempts of its action, `{Success: RESULT}` has one of
    several results.
    """


@dataclass(frozen=True)
class Imagined:
    """Result of a task that is run without a robot, with the outcome of each action taken from a script."""

    outcome: Literal["Success", "Fail", "GiveUp"]
    situation: str
    reason: str
    cost_s: float
    """Sum of the costs of its actions, in [s]."""
    lines: tuple[str, ...]
    """Description of each action and of each skipped element of a `repeat`, one line each."""
    skipped: tuple[str, ...] = ()
    """Elements of a `repeat` that are left undone."""

    def summary(self) -> dict[str, Any]:
        """Return the result of an imagined run (outcomes given by a script) as fields that can be written as
        JSON.
        """
        return {
            "outcome": self.outcome,
            "situation": self.situation,
            "reason": self.reason,
            "actions": len(self.lines) - len(self.skipped),
            "cost_s": self.cost_s,
            "did": list(self.lines),
            "skipped": list(self.skipped),
        }


def load_script(path: Path) -> Script:
    """Load a file with scripted outcomes; raises `FileError` if it is missing or invalid."""
    return load(path, Script)


def follow(network: ActionNetwork, outcomes: Iterable[Word | WithResult]) -> Imagined:
    """Return the run that the coordinator would make if its actions had the scripted outcomes.

    Args:
        network: the network.
        outcomes: outcome of each action of the run, in order; further actions succeed.
    """
    route, words, cost = RunDecisions(network, planner_of(network)), iter(outcomes), 0.0
    lines: list[str] = []
    skipped: list[str] = []

    def end(outcome: Literal["Success", "Fail", "GiveUp"], reason: str) -> Imagined:
        return Imagined(outcome, route.situation, reason, cost, tuple(lines), tuple(skipped))

    while not route.arrived:
        if not route.planned:
            plan = route.plan()
            if isinstance(plan, NoWay):
                return end("GiveUp" if plan.calls_person else "Fail", plan.explanation)
            if route.arrived:
                break
        action = route.next
        if action.binding is None:
            skipped.append(network.situations[action.source].element or action.source)
            lines.append(f"{len(lines) + 1}. {action}: {skipped[-1]} is left undone")
            route.took(Success())
            continue
        given = next(words, "Success")
        word, result = ("Success", given.success) if isinstance(given, WithResult) else (given, "")
        cost += action.cost_s
        said = f"{word} ({result})" if result else word
        lines.append(f"{len(lines) + 1}. {action}: {said}, {action.cost_s:g} s")
        if word == "GiveUp":
            return end("GiveUp", f"{action}: as the script says")
        if word == "Success":
            route.took(Success({}, result))
        else:
            route.failed("as the script says", word == "FailForGood")
    if route.lost is not None:
        return end("Fail", f"{route.lost.explanation}; otherwise: {route.situation} is reached")
    return end("Fail", f"left undone: {', '.join(skipped)}") if skipped else end("Success", "")
