"""The situations that can still follow a situation."""

from __future__ import annotations

import networkx as nx

from .network import ActionNetwork


def ways_of(network: ActionNetwork) -> nx.DiGraph[str]:
    """Return the graph of situations with an edge for each Success or Fail that leads to another one.

    No edge starts from the goal.
    """
    ways: nx.DiGraph[str] = nx.DiGraph()
    ways.add_nodes_from(network.situations)
    for action in network.actions:
        if action.source != network.goal:
            ways.add_edges_from((action.source, to) for to in action.leads_to)
    return ways


class Ahead:
    """Situations that a run can still reach from each situation of a network.

    Each set of situations is an integer with a bit for each situation, to save memory in large networks.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Compute the reachable situations of a network."""
        self._bit = {name: 1 << number for number, name in enumerate(network.situations)}
        ways = ways_of(network)
        whole = nx.condensation(ways)
        reached: dict[int, int] = {}
        for part in reversed(list(nx.topological_sort(whole))):
            bits = sum(self._bit[name] for name in whole.nodes[part]["members"])
            for following in whole.successors(part):
                bits |= reached[following]
            reached[part] = bits
        self._reached = {name: reached[part] for name, part in whole.graph["mapping"].items()}

    def bit(self, situation: str) -> int:
        """Return an integer in which only the bit of the given situation is set."""
        return self._bit[situation]

    def bits(self, situation: str) -> int:
        """Return an integer as a set of situations: a bit is 1 if its situation can be reached from
        `situation`.

        The bit of `situation` itself is 1, too.
        """
        return self._reached[situation]
