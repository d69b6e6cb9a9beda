"""Forecast of the ends of a task's runs, the most influential action, and the gain from more attempts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort, TooMuch
from handcart.networks.chains.policy import DEFAULT_MAX_STEPS, TooLarge, budget_of
from handcart.networks.chains.stage import Stage
from handcart.networks.entries.entry import TaskEntry
from handcart.networks.task.task_file import Task

from .forecast import Change, Forecast, Forecaster

FORECAST_ASSUMPTION = "attempts are independent of each other, and no Fail is for good"


@dataclass(frozen=True)
class Influence:
    """Influence of an action of a task file on the ends of the task's runs.

    An action in a `repeat` is copied for each element; the figures are for all copies together.
    """

    entry: int
    """Number of the action in the file."""
    words: str
    line: int
    """Line of the action in the file."""
    chance: Chance
    starts: float
    """Average number of times that a run starts the action."""
    slope: float
    """Derivative of P(goal) by the action's probability of Success, with its probability of Fail reduced
    as much.
    """
    one_more: Forecast | None
    """Forecast with one more attempt of the action; unchanged if it has the maximum already.

    None: a part of the network would have too many states, and only `bounds` are known.
    """
    alternative: Forecast | None
    """Forecast with a second action next to it, of the same cost, attempts and probabilities.

    None in the same case as `one_more`.
    """
    bounds: tuple[float, float] = (0.0, 0.0)
    """Least and largest change of P(goal) by one more attempt or by the alternative.

    Both change only runs in which the action fails.
    """


@dataclass(frozen=True)
class Figures:
    """Forecast of how runs of a task end, with the influence of each action on this forecast."""

    forecast: Forecast
    influences: tuple[Influence, ...]
    """Influences of the actions, the one with the largest effect on P(goal) first."""

    def for_programs(self) -> dict[str, Any]:
        """Return the forecast of how runs end, and each action's influence on it, as in `handcart check
        --json`.
        """
        forecast = {"assumption": FORECAST_ASSUMPTION, **_named(self.forecast)}
        return {**forecast, "actions": [_row(influence) for influence in self.influences]}


def entry_chances(task: Task) -> list[Chance]:
    """Return the outcome probabilities of each action of a task file; a probability that the file does not
    state is 0.
    """
    return [Chance(action.p_success or 0.0, action.p_give_up) for action in task.file.actions]


def network_chances(task: Task) -> list[Chance | None]:
    """Return the outcome probabilities of each action of the network.

    An entry is None for a skip: a skip leaves one element of a `repeat` (a part of the task that is done for
    each element of a list) undone, and has no outcomes.
    """
    known = entry_chances(task)
    return [None if entry is None else known[entry] for entry in task.entries]


def missing_chances(task: Task) -> list[int]:
    """Return the numbers (from 0, in the order of the task's file) of the actions without a probability
    `p`.
    """
    return [number for number, entry in enumerate(task.file.actions) if entry.p_success is None]


def figures(
    task: Task,
    effort: Effort | None = None,
    more: Effort | None = None,
    forecaster: Forecaster | None = None,
) -> Figures:
    """Return how runs of a task end, and how much each action influences these ends (`Figures`).

    All actions of the task must have a probability `p`.

    Args:
        task: the task.
        effort: budget of the forecast of the unchanged task, in steps of search; None: the default of the
            task's network (`budget_of`).
        more: budget of all forecasts with a changed action, those for `Influence.one_more` and
            `Influence.alternative`; None: `DEFAULT_MAX_STEPS` steps of search.
        forecaster: forecaster of the task's network, used with its own budget; None: a new one.
    """
    known = dict(enumerate(entry_chances(task)))
    budget = effort or Effort(budget_of(task.network))
    forecaster = forecaster or Forecaster(task.network, network_chances(task), budget)
    now = forecaster.forecast()
    starts, slopes = forecaster.starts(), forecaster.slopes()
    changed = _Changes(forecaster, more or Effort(DEFAULT_MAX_STEPS))
    copies: dict[int, list[int]] = {number: [] for number in known}
    for number, entry in enumerate(task.entries):
        if entry is not None:
            copies[entry].append(number)
    influences = [
        Influence(
            entry,
            _words(task.file.actions[entry]),
            task.document.position(("actions", entry))[0],
            known[entry],
            sum(starts[number] for number in numbers),
            sum(slopes[number] for number in numbers),
            changed.forecast(Stage.with_one_more, numbers),
            changed.forecast(Stage.with_alternatives, numbers),
            _bounds(now, known[entry].fail * sum(starts[number] for number in numbers)),
        )
        for entry, numbers in copies.items()
    ]
    influences.sort(key=lambda influence: (-round(influence.slope, 9), influence.entry))
    return Figures(now, tuple(influences))


class _Changes:
    """Forecasts of changed tasks, within a budget."""

    def __init__(self, forecaster: Forecaster, effort: Effort) -> None:
        self._forecaster, self._effort = forecaster, effort

    def forecast(self, change: Change, numbers: Sequence[int]) -> Forecast | None:
        try:
            return self._forecaster.forecast(change, frozenset(numbers), self._effort)
        except (TooLarge, TooMuch):
            return None


def _bounds(now: Forecast, fails: float) -> tuple[float, float]:
    """Return bounds on the change of P(goal), given the average number of Fails in a run.

    The share of runs with a Fail is at most that number, and only these runs change.
    """
    return -min(now.goal_high, fails), min(1.0 - now.goal, fails + now.unknown)


def _words(entry: TaskEntry) -> str:
    return f"{entry.do} ({entry.source} to {entry.target})"


def _row(each: Influence) -> Mapping[str, Any]:
    more, other = (_named(then) if then else {} for then in (each.one_more, each.alternative))
    return {
        "action": each.words,
        "line": each.line,
        "p": each.chance.success,
        "p_give_up": each.chance.give_up,
        "starts": each.starts,
        "slope": each.slope,
        "one_more_p_goal": more.get("p_goal"),
        "one_more_cost_s": more.get("cost_s"),
        "alternative_p_goal": other.get("p_goal"),
        "alternative_cost_s": other.get("cost_s"),
        "change_low": each.bounds[0],
        "change_high": each.bounds[1],
    }


def _named(forecast: Forecast) -> dict[str, float]:
    return {name if "cost" in name else f"p_{name}": value for name, value in asdict(forecast).items()}
