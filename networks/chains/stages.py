"""Cutting of a network into stages at the situations that every run passes."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence

import networkx as nx

from handcart.networks.graph.ahead import ways_of
from handcart.networks.graph.network import Action, ActionNetwork

from .stage import Stage


def stages(network: ActionNetwork) -> list[Stage]:
    """Return the stages of a network, which are parts that each successful run passes exactly once, in the
    order in which runs pass them.
    """
    ways = ways_of(network)
    above = dict(nx.immediate_dominators(ways, network.start))
    chain = _chain(above, network.start, network.goal)
    level = _levels(above, chain)
    steps = [(level[a], level[b]) for a, b in ways.edges if a in level]
    opened = _open(chain, [*steps, *_shared(network, level)])
    planned = {network.goal, *nx.ancestors(network.graph, network.goal)}
    cuts = [number for number in opened if number == 0 or chain[number] in planned]
    return _cut(network, level, cuts, [chain[number] for number in cuts])


def _chain(above: Mapping[str, str], start: str, goal: str) -> list[str]:
    """Return the situations that dominate the goal, from the start; the start alone if it is not reached."""
    if goal not in above:
        return [start]
    chain = [goal]
    while chain[-1] != start:
        chain.append(above[chain[-1]])
    return chain[::-1]


def _levels(above: Mapping[str, str], chain: Sequence[str]) -> dict[str, int]:
    """Return for each reachable situation the index of its last dominator in the chain."""
    level = {name: number for number, name in enumerate(chain)}
    for name in above:
        climbed = [name]
        while climbed[-1] not in level:
            climbed.append(above[climbed[-1]])
        level |= dict.fromkeys(climbed, level[climbed[-1]])
    return level


def _open(chain: Sequence[str], steps: Sequence[tuple[int, int]]) -> list[int]:
    """Return the levels at which the network can be cut: no step leads back from there or later to before."""
    closed = [0] * (len(chain) + 1)
    for source, to in steps:
        if to < source:
            closed[to + 1] += 1
            closed[source + 1] -= 1
    depth, cuts = 0, []
    for number in range(len(chain)):
        depth += closed[number]
        if depth == 0:
            cuts.append(number)
    return cuts


def _shared(network: ActionNetwork, level: Mapping[str, int]) -> Iterator[tuple[int, int]]:
    """Yield a step back for each counter of Fails that several levels share: these cannot be cut apart."""
    for actions in network.shared.values():
        if len(actions) > 1:
            levels = [level[action.source] for action in actions if action.source in level]
            if levels:
                yield max(levels), min(levels)


def _cut(
    network: ActionNetwork, level: Mapping[str, int], cuts: Sequence[int], names: Sequence[str]
) -> list[Stage]:
    goals = [*names[1:], network.goal]
    inside: list[list[str]] = [[] for _ in names]
    actions: list[list[Action]] = [[] for _ in names]
    for name in network.situations:
        if name in level:
            inside[bisect_right(cuts, level[name]) - 1].append(name)
    for action in network.actions:
        if action.source in level:
            actions[bisect_right(cuts, level[action.source]) - 1].append(action)
    return [
        _stage(network, [*inside[number], goal], actions[number], names[number], goal)
        for number, goal in enumerate(goals)
        if names[number] != network.goal
    ]


def _stage(
    network: ActionNetwork, inside: Sequence[str], actions: Sequence[Action], start: str, goal: str
) -> Stage:
    situations = [network.situations[name] for name in dict.fromkeys(inside)]
    part = ActionNetwork.build(situations, actions, start, goal)
    return Stage(part, tuple(action.index for action in actions))
