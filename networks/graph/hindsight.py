"""Reasons for the choice of an action: the alternatives at that time, with their costs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from handcart.networks.journal.past_run import PastAction, PastRun

from .network import Action, ActionNetwork
from .planner import SKIP_WEIGHT, NoWay, Plan, Planner


@dataclass(frozen=True)
class Way:
    """A route to the goal that was open at that time."""

    actions: tuple[Action, ...]
    cost: float
    """The sum of planning weights, in [s]."""


@dataclass(frozen=True)
class Option:
    """An action that leads out of the situation."""

    action: Action
    weight: float
    """Weight in planning at that time, in [s]: its cost, doubled by each Fail."""
    fails: int
    """Number of earlier Fails, including starts that were not possible."""
    way: Way | None
    """Cheapest route to the goal that begins with it; None if it was used up, or nothing leads on."""
    out: str
    """Reason why it was excluded; empty if it was open."""


@dataclass(frozen=True)
class Choice:
    """A choice, with its alternatives as computed afterwards."""

    chosen: Action
    way: Way
    """Plan that begins with the chosen action."""
    options: tuple[Option, ...]
    """All actions out of the situation: the chosen one first, then by cost."""
    next_best: Way | None
    """The cheapest other way, which may part from the plan later on; None where there was none."""
    after_fail: Way | None
    """Cheapest route after a Fail, if the Fail leads to another situation; planning does not consider it."""


def choice_of(run: PastRun, action: PastAction) -> Choice | None:
    """Return the choice of an action; None if the journal does not keep the network.

    The planner computes it again from the Fails that the journal counts up to that time.
    """
    if run.network is None:
        return None
    then = _Then(run, action)
    chosen = run.network.network.actions[action.index]
    plan = then.plan(action.source)
    if isinstance(plan, NoWay):
        return None
    options = [then.option(each) for each in then.network.actions if each.source == action.source]
    options.sort(key=lambda each: (each.action.index != chosen.index, each.way is None, _cost(each)))
    others = [then.plan(action.source, without=each) for each in plan.actions]
    ways = [Way(other.actions, other.cost) for other in others if isinstance(other, Plan)]
    return Choice(
        chosen,
        Way(plan.actions, plan.cost),
        tuple(options),
        min(ways, key=lambda way: way.cost, default=None),
        then.after_fail(chosen),
    )


class _Then:
    """The planner in its state before an action."""

    def __init__(self, run: PastRun, action: PastAction) -> None:
        assert run.network is not None
        self.network: ActionNetwork = run.network.network
        self._fails = list(_fails(run, action))

    def plan(self, situation: str, without: Action | None = None) -> Plan | NoWay:
        return self._planner(without).plan(situation)

    def after_fail(self, action: Action) -> Way | None:
        if action.on_fail is None:
            return None
        planner = self._planner()
        planner.failed(action, "")
        plan = planner.plan(action.on_fail)
        return Way(plan.actions, plan.cost) if isinstance(plan, Plan) else None

    def option(self, action: Action) -> Option:
        fails = sum(index == action.index for index, _ in self._fails)
        weight = SKIP_WEIGHT if action.binding is None else action.cost_s * 2.0**fails
        for_good = any(index == action.index and permanent for index, permanent in self._fails)
        if for_good or fails >= action.attempts:
            why = "failed for good" if for_good else f"failed {fails} of {action.attempts} times"
            return Option(action, weight, fails, None, f"used up: {why}")
        rest = self.plan(action.target)
        if isinstance(rest, NoWay):
            return Option(action, weight, fails, None, f"nothing leads on from {action.target}")
        if any(each.source == action.source for each in rest.actions):
            return Option(action, weight, fails, None, "leads only back here")
        return Option(action, weight, fails, Way((action, *rest.actions), weight + rest.cost), "")

    def _planner(self, without: Action | None = None) -> Planner:
        planner = Planner(self.network)
        for index, permanent in self._fails:
            planner.failed(self.network.actions[index], "", permanent=permanent)
        if without is not None:
            planner.failed(without, "", permanent=True)
        return planner


def _fails(run: PastRun, action: PastAction) -> Iterator[tuple[int, bool]]:
    """Each counted Fail before an action: the index of what failed, and whether for good."""
    indices = {each.number: each.index for each in run.actions}
    started: dict[int, int] = {}
    for record in run.before(action):
        if record["kind"] == "RESULT" and record["outcome"] == "Fail":
            yield indices[record["n"]], bool(record["permanent"])
        elif record["kind"] in ("START", "RESULT"):
            started[record["q"]] = indices[record["n"]]
        elif record["kind"] == "NOT_STARTED" or (record["kind"] == "RECON" and record["situation"]):
            yield int(record["action"]), False
        elif record["kind"] == "ACK" and record["record"] in started:  # from there on it counts as a Fail
            yield started[record["record"]], False


def _cost(option: Option) -> float:
    return option.way.cost if option.way is not None else option.weight
