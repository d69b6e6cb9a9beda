"""CPU time of planning again after one Fail, over that of networkx in the same process:
`python -m benchmarks.deciding.replanning`.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time

import networkx as nx

from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.graph.planner import Plan, Planner

from .random_networks import ANY_BINDING

TIME_LIMITS_S = {1_000: 0.3, 10_000: 0.1, 100_000: 0.02}
MAX_FAILS = 12


def drawn_network(count: int, seed: int) -> ActionNetwork:
    """Draw a network with two actions out of each situation, to any other."""
    draws = random.Random(seed)
    actions = [
        Action(f"s{here}", f"s{draws.randrange(count)}", ANY_BINDING, draws.uniform(1.0, 60.0))
        for here in range(count)
        for _ in range(2)
    ]
    goal = f"s{count - 1}"
    return ActionNetwork.build([Situation(f"s{number}") for number in range(count)], actions, "s0", goal)


def main() -> None:
    """Print a line for each size."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.deciding.replanning", description=__doc__)
    words.add_argument("--seeds", type=int, nargs="*", default=[1, 2, 3])
    words.add_argument("--sizes", type=int, nargs="*", default=list(TIME_LIMITS_S))
    given = words.parse_args()
    for count in given.sizes:
        print(f"{count} situations ...", flush=True)
        pairs = [pair for seed in given.seeds for pair in _pairs(drawn_network(count, seed))]
        ours, theirs = (statistics.median(times) for times in zip(*pairs, strict=True))
        limit = f" (allowed: {TIME_LIMITS_S[count]:g})" if count in TIME_LIMITS_S else ""
        times = f"{1e3 * ours:.3f} ms, networkx {1e3 * theirs:.3f} ms"
        print(f"  median of {len(pairs)}: {times}, ratio {ours / theirs:.4f}{limit}", flush=True)


def _pairs(network: ActionNetwork) -> list[tuple[float, float]]:
    """Return our time and that of networkx, in [s], after a Fail of each action of the plan."""
    planner = Planner(network)
    plan = planner.plan(network.start)
    if not isinstance(plan, Plan):
        return []
    graph: nx.DiGraph[str] = nx.DiGraph()
    for item in network.actions:
        known = graph.get_edge_data(item.source, item.target, {"weight": item.cost_s})["weight"]
        graph.add_edge(item.source, item.target, weight=min(known, item.cost_s))
    return [_timed(planner, graph, action) for action in plan.actions[:MAX_FAILS]]


def _timed(planner: Planner, graph: nx.DiGraph[str], failed: Action) -> tuple[float, float]:
    network = planner.network
    again = Planner(network, planner.search())
    again.failed(failed, "")
    begin = time.process_time()
    plan = again.plan(network.start)
    planned = time.process_time()
    edge = graph[failed.source][failed.target]
    before, edge["weight"] = edge["weight"], 2.0 * failed.cost_s
    middle = time.process_time()
    cost, _ = nx.single_source_dijkstra(graph, network.start, network.goal)
    end = time.process_time()
    edge["weight"] = before
    assert isinstance(plan, Plan) and abs(plan.cost - cost) < 1e-6, "the plans differ"
    return planned - begin, end - middle


if __name__ == "__main__":
    main()
