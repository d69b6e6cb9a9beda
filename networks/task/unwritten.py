"""Late-bound parameters that nothing finds out before they are needed."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import networkx as nx

from handcart.networks.graph.network import Action, ActionNetwork
from handcart.primitives.knowledge.world_model import WorldModel


def unwritten(network: ActionNetwork, given: Collection[str]) -> Iterator[tuple[Action, str, str]]:
    """Yield actions that may start before a parameter's value in the world model is known.

    If the world model does not know an entry at first, an action on every route to the action that needs the
    entry has to find it out.

    Args:
        network: the complete network.
        given: entries of the world model that files of the task fill.

    Yields:
        The action, the name of its parameter, and the parameter's key in the world model, such as `cup.size`.
    """
    empty = WorldModel.unknown_at_first() - set(given)
    ways = _ways(network)
    known: dict[str, set[str]] = {}
    for action in network.actions:
        for name, key in (action.binding.late if action.binding else {}).items():
            entry = key.split(".")[0]
            if entry not in known:
                known[entry] = _reached(ways, [a for a in network.actions if _writes(a, entry)])
            if entry in empty and action.source not in known[entry]:
                yield action, name, key


def _writes(action: Action, entry: str) -> bool:
    return action.binding is not None and entry in action.binding.kind.writes


def _ways(network: ActionNetwork) -> nx.DiGraph[str]:
    """Return the graph of situations, with an edge to each that an action may lead to, also after a Fail."""
    ways: nx.DiGraph[str] = nx.DiGraph()
    ways.add_nodes_from(network.situations)
    ways.add_edges_from((a.source, to) for a in network.actions for to in a.leads_to)
    return ways


def _reached(ways: nx.DiGraph[str], writers: list[Action]) -> set[str]:
    """Return the situations in which one of these actions may have been done, or tried."""
    seen = {action.source for action in writers}
    waiting = [to for source in seen for to in ways.successors(source)]
    while waiting:
        if (there := waiting.pop()) not in seen:
            seen.add(there)
            waiting.extend(ways.successors(there))
    return seen
