"""Check what `handcart explain` says of alternatives, on random networks, by a solver of its own.

    python -m benchmarks.deciding.explained [--networks 50] [--first 0]

Each network is followed by the rule with drawn outcomes. Before some of its actions, each alternative's
P(goal) and mean time are compared with those of a solver in plain Python that shares no code with the
package, and its threshold with what the rule chooses just below and above it. Prints the share of what
is said that is right within 1e-3; status 1 if one is not.
"""

from __future__ import annotations

import argparse
import random
from collections.abc import Iterator, Mapping
from dataclasses import replace

from handcart.networks.deciding.option_values import OptionValues
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.plan_search import PlanSearch
from handcart.networks.graph.planner import NoWay, Plan
from handcart.networks.graph.route import RunDecisions
from handcart.networks.past_runs.hindsight import OpenRoute, Option
from handcart.primitives.outcomes.outcome import Success

from .plain_solver import PlainNetwork, RuleEnds, plain_network, rule_ends
from .random_networks import NETWORK_FAMILIES, Drawn, drawn

MAX_DECISIONS = 3
"""Decisions of one run that are looked at."""
MOST_SITUATIONS = 8
"""Maximum number of situations of a network that the solver in plain Python can handle."""
VALUE_TOLERANCE = 1e-3
"""Tolerance of P(goal), and relative tolerance of the time."""
COST_MARGIN = 1e-6


def with_chances(found: Drawn) -> ActionNetwork:
    """Return the network with its probabilities in its actions, as a task's file has them."""
    pairs = zip(found.network.actions, found.chances, strict=True)
    actions = [replace(a, p=c.success, p_give_up=c.give_up) if c else a for a, c in pairs]
    return rebuilt(found.network, actions)


def rebuilt(network: ActionNetwork, actions: list[Action]) -> ActionNetwork:
    """Return the network with other actions."""
    return ActionNetwork.build(network.situations.values(), actions, network.start, network.goal)


def solved(net: PlainNetwork, index: int, counts: Mapping[int, int], hopes: bool) -> tuple[float, float]:
    """Return P(goal) and mean time if an action is done first, by the plain solver.

    With `hopes` the action has to fail to lead on, and a Success uses up an attempt.
    """
    edge, fails = net.edges[index], tuple(counts.get(n, 0) for n in range(len(net.edges)))
    more = (*fails[:index], fails[index] + 1, *fails[index + 1 :])
    goal, time = 0.0, edge.cost
    for p, to, left in (
        (edge.p, edge.target, more if hopes else fails),
        (edge.fail, edge.on_fail or edge.source, more),
    ):
        if to == net.goal:
            goal += p
        elif p > 1e-12:
            ends: RuleEnds = rule_ends(net, 1e-6, begin=net.at(to, left))
            goal, time = goal + p * ends.goal.low, time + p * ends.time
    return goal, time


def decisions(network: ActionNetwork, seed: int) -> Iterator[tuple[RunDecisions, Plan]]:
    """Yield the decisions of one run, before each is carried out."""
    route, draws = RunDecisions(network), random.Random(seed)
    while not route.arrived:
        if not route.planned and isinstance(route.plan(), NoWay):
            return
        plan = route.planner.plan(route.situation)
        if isinstance(plan, NoWay):
            return
        yield route, plan
        action, luck = route.next, draws.random()
        if luck < (action.p or 0.0):
            route.took(Success())
        elif luck < (action.p or 0.0) + action.p_give_up:
            return
        else:
            route.failed("drawn")


def is_threshold_right(route: RunDecisions, plan: Plan, action: Action) -> bool:
    """Return whether the rule chooses an action just below its threshold, and not just above."""
    search, fails = PlanSearch(route.network), route.planner.fails(action)
    others = [item for item in route.network.actions if item.source == action.source]
    rest = route.planner.plan(action.target, without=others)
    if isinstance(rest, NoWay) or plan.actions[0] is action or plan.hopes or rest.hopes:
        return True
    weight = search.weight(action, route.planner.counts)
    way = OpenRoute((action, *rest.actions), weight + rest.cost)
    threshold = Option(action, weight, fails, way, "").threshold_s(OpenRoute(plan.actions, plan.cost))
    below = (threshold or 0.0) - COST_MARGIN
    tried = [(cost, cost < (threshold or 0.0)) for cost in (below, below + 2.0 * COST_MARGIN) if cost > 0.0]
    return all(_chooses(route, action, cost) is expected for cost, expected in tried)


def _chooses(route: RunDecisions, action: Action, cost_s: float) -> bool:
    actions = [replace(a, cost_s=cost_s) if a is action else a for a in route.network.actions]
    again = RunDecisions(rebuilt(route.network, actions))
    again.planner.counts |= route.planner.counts
    plan = again.planner.plan(route.situation)
    return isinstance(plan, Plan) and plan.actions[0].index == action.index


def looked_at(family: str, seed: int) -> Iterator[tuple[str, bool | None]]:
    """Yield a line for each alternative of a network's decisions, and whether what is said of it is right.

    None: nothing is said, because there are too many states.
    """
    found = drawn(family, seed, MOST_SITUATIONS)
    network, net = with_chances(found), plain_network(found)
    values = OptionValues(network)
    for number, (route, plan) in enumerate(decisions(network, seed)):
        if number == MAX_DECISIONS:
            return
        for action in network.actions:
            if action.source != route.situation or route.planner.is_out(action):
                continue
            hopes = plan.hopes and len(plan.actions) == 1 and plan.actions[0].index == action.index
            value = values.of(action, route.planner.counts, hopes)
            goal, time = solved(net, action.index, route.planner.counts, hopes)
            name = f"{family} {seed}, decision {number + 1}, action {action.index}"
            if value is None:
                yield f"{name}: too many states", None
                continue
            near = (
                abs(value.goal - goal) <= VALUE_TOLERANCE
                and abs(value.mean_s - time) <= VALUE_TOLERANCE * time
            )
            said = (
                f"P(goal) {value.goal:.6f} by the solver {goal:.6f}, {value.mean_s:.3f} s by it {time:.3f} s"
            )
            yield f"{name}: {said}", near and is_threshold_right(route, plan, action)


def main() -> None:
    """Print the share that is right."""
    words = argparse.ArgumentParser(
        prog="python -m benchmarks.deciding.explained",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    words.add_argument("--networks", type=int, default=50)
    words.add_argument("--first", type=int, default=0)
    given = words.parse_args()
    right = total = unsaid = 0
    for seed in range(given.first, given.first + given.networks):
        family = NETWORK_FAMILIES[seed % len(NETWORK_FAMILIES)]
        print(f"network {seed} ({family})", flush=True)
        for line, is_right in looked_at(family, seed):
            unsaid += is_right is None
            right, total = right + bool(is_right), total + (is_right is not None)
            if is_right is False:
                print(f"  WRONG {line}", flush=True)
    share = f"{right} of {total} alternatives in {given.networks} networks are right"
    print(f"{share}: {100 * right / total:.1f} %; of {unsaid} more nothing is said: too many states")
    raise SystemExit(0 if right == total else 1)


if __name__ == "__main__":
    main()
