"""Reasons for the choice of an action: the alternatives at that time, with their costs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from handcart.networks.deciding.belief_planner import BeliefPlanner
from handcart.networks.deciding.option_values import OptionValue
from handcart.networks.deciding.planners import planner_of
from handcart.networks.graph.belief_prior import Judged
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.plan_search import PlanSearch
from handcart.networks.graph.planner import NoWay, Plan, Planner
from handcart.primitives.outcomes.causes import PREEMPTED, REFUSED

from .past_run import PastAction, PastRun, Record


@dataclass(frozen=True)
class OpenRoute:
    """A route to the goal that a run could have taken when it made a certain decision."""

    actions: tuple[Action, ...]
    cost: float
    """The sum of planning weights, in [s]."""


@dataclass(frozen=True)
class FailRoute:
    """The cheapest route to the goal after an action has failed with a certain cause."""

    cause: str
    """Cause of the Fail; empty for all causes that `Action.fail_endings` does not name."""
    situation: str
    way: OpenRoute


@dataclass(frozen=True)
class Option:
    """An action that a run could have chosen in a decision, with reasons for and against it."""

    action: Action
    weight: float
    """Weight in planning at that time, in [s]: its cost, doubled by each Fail."""
    fails: int
    """Number of earlier Fails, including starts that were not possible."""
    way: OpenRoute | None
    """Cheapest route to the goal that begins with it; None if it was used up, or nothing leads on."""
    out: str
    """Reason why it was excluded; empty if it was open."""
    value: OptionValue | None = None
    """Expected result of a run with it, by the probabilities in the file; None if they are unknown."""
    believed: float | None = None
    """Probability of Success by the beliefs of the run; None without beliefs."""

    def threshold_s(self, chosen: OpenRoute) -> float | None:
        """Return the cost below which the rule would have chosen this action, in [s].

        The rule chooses the first action of the cheapest plan to the goal. The result is None if no plan
        begins with the action, or if the rule would not have chosen it at any cost.
        """
        if self.way is None:
            return None
        cost = (self.weight - (self.way.cost - chosen.cost)) / 2.0**self.fails
        return cost if cost > 0.0 else None


@dataclass(frozen=True)
class Choice:
    """A run's choice of one action, with the alternatives as computed from the journal afterwards."""

    chosen: Action
    way: OpenRoute
    """Plan that begins with the chosen action."""
    options: tuple[Option, ...]
    """All actions out of the situation: the chosen one first, then by cost."""
    next_best: OpenRoute | None
    """The cheapest other route, which may share its begin with the plan; None if there was none."""
    after_fails: tuple[FailRoute, ...]
    """Cheapest routes after a Fail, by its cause, which planning does not consider.

    Causes that leave the situation as it is, and those after which no route is left, are not included.
    """
    policy: str = "rule"
    """Policy by which the run chose, as the task's file names it."""
    judged: Judged | None = None
    """Judgement of that policy by the beliefs of the run; None without beliefs."""


def choice_of(run: PastRun, action: PastAction) -> Choice | None:
    """Return the choice by which a run started an action, with the alternatives.

    The network's planner computes the choice again, from the Fails that the journal holds before the action.

    Returns:
        The choice; None if the journal does not keep the network, or the planner finds no route any more.
    """
    if run.network is None:
        return None
    then = _Then(run, action)
    chosen = run.network.network.actions[action.index]
    plan = then.plan(action.source)
    if isinstance(plan, NoWay):
        return None
    options = [then.option(item) for item in then.network.actions if item.source == action.source]
    options.sort(key=lambda option: (option.action.index != chosen.index, option.way is None, _cost(option)))
    others = [then.plan(action.source, without=(item,)) for item in plan.actions]
    ways = [OpenRoute(other.actions, other.cost) for other in others if isinstance(other, Plan)]
    return Choice(
        chosen,
        OpenRoute(plan.actions, plan.cost),
        tuple(options),
        min(ways, key=lambda way: way.cost, default=None),
        tuple(then.after_fails(chosen)),
        then.judged.follows if then.judged else then.network.policy,
        then.judged,
    )


def counts_now(run: PastRun) -> dict[int, int]:
    """Return the counts of Fails and renewals (`Attempts`) at a run's end.

    The keys are numbers of counters (`Action.counter`); actions that share their attempts share a counter.

    Counts of 0 may be missing. The journal of the run must keep its network.
    """
    assert run.network is not None
    planner = Planner(run.network.network)
    _count(planner, _counted(run, run.records))
    return planner.counts


class _Then:
    """The planner in its state before an action."""

    def __init__(self, run: PastRun, action: PastAction) -> None:
        assert run.network is not None
        self.network: ActionNetwork = run.network.network
        self._search = PlanSearch(self.network)
        self._events = list(_counted(run, run.before(action)))
        self._planner = self._new_planner()
        goal = _pursued(run, action)
        self._goal = None if goal == self.network.goal else goal
        self.judged = _judged(run, action)
        planner = self._planner
        self._beliefs = planner.beliefs.chances() if isinstance(planner, BeliefPlanner) else None
        self._values = run.network.values.by(self._beliefs, self.judged and self.judged.follows)
        begun = max((n for n, (_, word) in enumerate(self._events) if word == ROUND), default=0)
        self._for_good = {index for index, word in self._events[begun:] if word == FOR_GOOD}

    def plan(self, situation: str, without: Sequence[Action] = ()) -> Plan | NoWay:
        return self._planner.plan(situation, self._goal, without=without)

    def after_fails(self, action: Action) -> Iterator[FailRoute]:
        planner = self._new_planner()
        planner.failed(action, "")
        ends = [("", action.on_fail), *((ending.cause, ending.target) for ending in action.fail_endings)]
        for cause, situation in ends:
            plan = None if situation is None else planner.plan(situation, self._goal)
            if situation is not None and isinstance(plan, Plan):
                yield FailRoute(cause, situation, OpenRoute(plan.actions, plan.cost))

    def option(self, action: Action) -> Option:
        fails = self._planner.fails(action)
        weight = self._search.weight(action, {}) * 2.0**fails
        if self._planner.is_out(action):
            times = f"failed {fails} of {action.attempts} times"
            why = "failed for good" if action.index in self._for_good else times
            return Option(action, weight, fails, None, f"used up: {why}")
        others = [item for item in self.network.actions if item.source == action.source]
        rest = self.plan(action.target, without=others)
        value = self._value(action)
        chance = None if self._beliefs is None else self._beliefs[action.index]
        believed = None if chance is None else chance.success
        if isinstance(rest, Plan):
            route = OpenRoute((action, *rest.actions), weight + rest.cost)
            return Option(action, weight, fails, route, "", value, believed)
        leads = isinstance(self.plan(action.target), Plan)
        out = "leads only back here" if leads else f"nothing leads on from {action.target}"
        return Option(action, weight, fails, None, out, value, believed)

    def _value(self, action: Action) -> OptionValue | None:
        """Return the expected result of a run that does an action next; None if it is not known."""
        if not self._values.are_known:
            return None
        plan = self.plan(action.source)
        hopes = isinstance(plan, Plan) and plan.hopes and plan.actions == (action,)
        return self._values.of(action, self._planner.counts, hopes)

    def _new_planner(self) -> Planner:
        planner = Planner(self.network, self._search)
        if self.network.policy != "rule":
            planner = planner_of(self.network)
        _count(planner, self._events)
        return planner


SUCCEEDED, FAILED, FOR_GOOD = "succeeded", "failed", "failed for good"
HOPED, ROUND = "succeeded, and had to fail", "another round began"


def _count(planner: Planner, events: Iterable[tuple[int, str]]) -> None:
    """Count events of a run, as `_counted` yields them, in a planner."""
    for index, word in events:
        if word == ROUND:
            planner.begin_again()
        elif word == SUCCEEDED:
            planner.succeeded(planner.network.actions[index])
        elif word == HOPED:
            planner.hoped(planner.network.actions[index])
        elif word == REFUSED.name:
            planner.refused(planner.network.actions[index], "")
        else:
            planner.failed(planner.network.actions[index], "", permanent=word == FOR_GOOD)


def _counted(run: PastRun, records: Iterable[Record]) -> Iterator[tuple[int, str]]:
    """Yield all that counts in records of a run: index and outcome of ended actions; -1 for a new round."""
    indices = {item.number: item.index for item in run.actions}
    started: dict[int, int] = {}
    needed: int | None = None  # the action whose Fail is needed, by the last plan
    for record in records:
        kind = record["kind"]
        if kind == "AIM" and record["what"] == "round":
            yield -1, ROUND
        if kind == "PLAN":
            needed = _needs_fail(run, record.get("way", ()))
        hoped = kind == "RESULT" and indices[record["n"]] == needed
        if kind == "RESULT" and record["outcome"] == "Success":
            yield indices[record["n"]], SUCCEEDED
            if hoped:
                yield indices[record["n"]], HOPED
        elif _is_preempted(record):
            continue
        elif kind == "RESULT" and record["outcome"] == "Fail":
            yield indices[record["n"]], FOR_GOOD if record["permanent"] else FAILED
        elif kind in ("START", "RESULT"):
            started[record["q"]] = indices[record["n"]]
        elif kind == "NOT_STARTED" and record.get("cause") == REFUSED.name:
            yield int(record["action"]), REFUSED.name
        elif kind == "NOT_STARTED" or (kind == "RECON" and record["situation"]):
            yield int(record["action"]), FAILED
        elif kind == "ACK" and record["record"] in started:  # from there on it counts as a Fail
            yield started[record["record"]], FAILED


def _is_preempted(record: Record) -> bool:
    """Return whether a record ends an action that was preempted, so that its attempt does not count."""
    if record["kind"] == "NOT_STARTED":
        return bool(record.get("cause") == PREEMPTED.name)
    causes = record.get("cause") if record["kind"] == "RESULT" else None
    return bool(causes and causes[0].get("kind") == PREEMPTED.name)


def _pursued(run: PastRun, action: PastAction) -> str:
    """Return the situation that the last plan before an action leads to: the goal, or one that came first."""
    assert run.network is not None
    network = run.network.network
    interrupts = (goal for interrupt in network.aims.interrupts for goal in interrupt.goals)
    ends = {network.goal, *network.otherwise, *interrupts}
    ways = [item["way"] for item in run.before(action) if item["kind"] == "PLAN" and item.get("way")]
    last = network.actions[ways[-1][-1]].target if ways else network.goal
    return last if last in ends else network.goal


def _judged(run: PastRun, action: PastAction) -> Judged | None:
    """Return the judgement that the journal keeps of the last plan before an action."""
    plans = [item for item in run.before(action) if item["kind"] == "PLAN"]
    kept = plans[-1].get("judged") if plans else None
    return None if kept is None else Judged.read(kept)


def _needs_fail(run: PastRun, way: Sequence[int]) -> int | None:
    """Return the last action of a plan if it leads to the goal by a Fail alone."""
    assert run.network is not None
    network = run.network.network
    interrupts = {goal for interrupt in network.aims.interrupts for goal in interrupt.goals}
    ends = {network.goal, *network.otherwise, *interrupts}
    return way[-1] if way and network.actions[way[-1]].target not in ends else None


def _cost(option: Option) -> float:
    return option.way.cost if option.way is not None else option.weight
