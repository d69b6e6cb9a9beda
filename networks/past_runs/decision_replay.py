"""Replay of a run's decisions: today's code on the outcomes in the journal, up to the first difference."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import NoWay, Plan
from handcart.networks.graph.route import RunDecisions
from handcart.networks.journal.retracing import NeedsOperator, RunPosition, standing

from .past_run import PastRun, Record

COST_TOLERANCE = 1e-9
"""Relative difference of costs that another order of additions explains."""


@dataclass(frozen=True)
class DecisionDifference:
    """First decision of a past run that the present code makes differently."""

    record: int
    """Number of the journal's record."""
    time_s: float
    """Time of the record, in [s] of the robot."""
    journal: str
    """Decision of the run, as text."""
    today: str
    """Decision of today's code, as text."""
    why: str
    """Reason in words; empty if there is no more to say."""

    def words(self) -> str:
        """Describe in one sentence how the past run decided, and how the present code decides instead."""
        why = f"; {self.why}" if self.why else ""
        where = f"record {self.record} at {self.time_s:.3f} s"
        return f"{where}: the run {self.journal}, today's code {self.today}{why}"


@dataclass(frozen=True)
class DecisionReplay:
    """Result of making a past run's decisions again with the present code.

    It has the numbers of plans and actions that are equal, and the first difference.
    """

    plans: int
    """Number of plans that are equal."""
    actions: int
    """Number of started actions that were next by today's code, too."""
    difference: DecisionDifference | None


def replay_decisions(run: PastRun) -> DecisionReplay | None:
    """Make a past run's decisions again with the present code, and compare them with the journal.

    The network and the outcomes are those in the journal. The comparison ends at the first difference.

    Args:
        run: the past run.

    Returns:
        The comparison; None if the journal does not keep the network.
    """
    if run.network is None:
        return None
    network = run.network.network
    header = {**run.header, "network": network.fingerprint()}
    position = standing(network, [header])
    plans = actions = 0
    for record in run.records[1:]:
        found = _planned(position, record) if record["kind"] == "PLAN" else _followed(position, record)
        if found is not None:
            return DecisionReplay(plans, actions, found)
        plans += record["kind"] == "PLAN"
        actions += record["kind"] == "START"
    return DecisionReplay(plans, actions, None)


def _planned(position: RunPosition, record: Record) -> DecisionDifference | None:
    """Plan, and compare with the plan in the journal."""
    route = position.route
    if record["situation"] != route.situation:
        here = f"is in situation {route.situation}"
        return _differs(record, f"planned in situation {record['situation']}", here)
    plan = route.plan()
    position.plans += 1
    excluded = [action.index for action in (plan.excluded if isinstance(plan, Plan) else plan.blocking)]
    judged = None if plan.judged is None else plan.judged.fields()
    if "judged" in record and record["judged"] != judged:
        return _differs(record, f"judged {_judged(record['judged'])}", f"judges {_judged(judged)}")
    if isinstance(plan, Plan) and "way" in record:
        way = [action.index for action in plan.actions]
        same_cost = math.isclose(record["cost"], plan.cost, rel_tol=COST_TOLERANCE)
        if way == record["way"] and same_cost and excluded == record["excluded"]:
            return None
    elif isinstance(plan, NoWay) and "no_way" in record:
        if excluded == record["excluded"]:
            return None
        return _differs(record, f"found no way: {record['no_way']}", f"says: {plan.explanation}")
    return _differs(record, _journaled(route.network, record), _today(plan), _why(route, record, plan))


def _followed(position: RunPosition, record: Record) -> DecisionDifference | None:
    """Follow a record that is not a plan, and compare the end of the run."""
    route = position.route
    if record["kind"] == "END":
        return _ended(position, record)
    following = str(route.next) if route.planned else "plans first"
    try:
        position.followed([record])
    except NeedsOperator as unfit:
        did = _did(route.network, record)
        return _differs(record, did, f"does {following}" if route.planned else following, str(unfit))
    return None


def _ended(position: RunPosition, record: Record) -> DecisionDifference | None:
    route, outcome = position.route, record["outcome"]
    is_left = position.skipped or route.unfinished or route.has_next_round
    is_done = route.arrived and not is_left and route.lost is None
    if outcome == "Success" and not is_done:
        return _differs(record, f"ended in {route.situation}", "goes on")
    if outcome == "Fail" and is_done:
        return _differs(record, f"ended in Fail: {record['reason']}", f"is at the goal {route.goal}")
    position.followed([record])
    return None


def _judged(fields: Mapping[str, Any] | None) -> str:
    if fields is None:
        return "no policy by beliefs"
    beliefs = ", ".join(f"{entry}: {a:g}/{b:g}" for entry, a, b in fields["beliefs"])
    share = f"better in {fields['better']:.1%} of draws"
    return f"that {fields['follows']} is to be followed ({share}; beliefs {beliefs or 'as at first'})"


def _differs(record: Record, journal: str, today: str, why: str = "") -> DecisionDifference:
    return DecisionDifference(int(record["q"]), float(record["t"]), journal, today, why)


def _did(network: ActionNetwork, record: Record) -> str:
    if record["kind"] == "START":
        words = record["action"]
        return f"did {words['do']} ({words['from']} to {words['to']})"
    return f"noted {record['kind']}"


def _journaled(network: ActionNetwork, record: Record) -> str:
    if "error" in record:
        return "could not plan"
    if "way" not in record:
        return f"found no way: {record.get('no_way', '')}"
    return f"planned {_names(network, record['way'])} for {record['cost']:g} s"


def _names(network: ActionNetwork, way: Sequence[int]) -> str:
    known = [str(network.actions[index]) for index in way if 0 <= index < len(network.actions)]
    return ", ".join(known) or "nothing"


def _today(plan: Plan | NoWay) -> str:
    if isinstance(plan, NoWay):
        return f"finds no way: {plan.explanation}"
    return f"plans {', '.join(map(str, plan.actions)) or 'nothing'} for {plan.cost:g} s"


def _why(route: RunDecisions, record: Record, plan: Plan | NoWay) -> str:
    """Return why today's planner does not choose the journal's route."""
    planner, actions = route.planner, route.network.actions
    way = [actions[index] for index in record.get("way", ()) if 0 <= index < len(actions)]
    if out := [item for item in way if planner.is_out(item)]:
        return f"{out[0]} is used up: it failed {planner.fails(out[0])} of {out[0].attempts} times"
    if not way or isinstance(plan, NoWay):
        return ""
    search = planner.search(route.goal)
    cost = sum((search.weight(item, planner.counts) for item in way), 0.0)
    if [action.index for action in plan.actions] == record["way"]:
        return "the route is the same, its cost or what is used up is not"
    if math.isclose(cost, plan.cost, rel_tol=COST_TOLERANCE):
        return f"both routes cost {cost:g} s by today's weights: another of equal ones"
    return f"by today's weights the run's route costs {cost:g} s"
