"""Placing the situations of a network in layers, so that most ways lead downwards and none through a box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import networkx as nx

from handcart.networks.graph.network import Action, ActionNetwork

BOX = 190.0  # width of a situation, all in [px]
LANE = 110.0  # width of a way that passes a layer, with its label
GAP = 30.0
ROW = 150.0
SWEEPS = 12  # times that the layers are sorted by their neighbours, down and up


class Line(NamedTuple):
    """Where an action leads: with Success, or with a declared Fail."""

    source: str
    target: str
    action: Action
    failed: bool


class Point(NamedTuple):
    """A place on the paper, in [px]; the first row's middle is the origin, y points down."""

    x: float
    y: float


class Layout(NamedTuple):
    """Where everything stands."""

    boxes: Mapping[str, Point]
    """The middle of each situation."""
    between: Sequence[Sequence[Point]]
    """For each line the places in which it passes the layers between its ends."""


def lines_of(network: ActionNetwork) -> list[Line]:
    """All ways, in the order of the actions."""
    lines = []
    for action in network.actions:
        lines.append(Line(action.source, action.target, action, False))
        if action.on_fail:
            lines.append(Line(action.source, action.on_fail, action, True))
    return lines


def lay_out(network: ActionNetwork, lines: Sequence[Line]) -> Layout:
    """A place for everything: longest ways from the start downwards, sorted by the neighbours' mean.

    Source: Sugiyama, Tagawa and Toda, Methods for visual understanding of hierarchical systems (1981).
    """
    rank = _ranks(network, lines)
    chains = [_chain(number, line, rank) for number, line in enumerate(lines)]
    rows: list[list[str]] = [[] for _ in range(max(rank.values()) + 1)]
    for name in network.situations:
        rows[rank[name]].append(name)
    for chain in chains:
        for name, layer in chain[1:-1]:
            rows[layer].append(name)
    near: nx.DiGraph[str] = nx.DiGraph()
    near.add_nodes_from(network.situations)
    for chain in chains:
        downwards = sorted(chain, key=lambda cell: cell[1])
        near.add_edges_from((a, b) for (a, _), (b, _) in pairwise(downwards) if a != b)
    across = _sorted(rows, near, network)
    points = {name: Point(across[name], ROW * layer) for layer, row in enumerate(rows) for name in row}
    return Layout(
        {name: points[name] for name in network.situations},
        [[points[name] for name, _ in chain[1:-1]] for chain in chains],
    )


def _ranks(network: ActionNetwork, lines: Sequence[Line]) -> dict[str, int]:
    """The layer of each situation, with the ways that close a cycle turned round."""
    ways: nx.DiGraph[str] = nx.DiGraph()
    ways.add_nodes_from([network.start, *network.situations])
    ways.add_edges_from((line.source, line.target) for line in lines if line.source != line.target)
    open_: list[str] = []
    back = []
    for source, target, kind in nx.dfs_labeled_edges(ways):
        if kind == "forward":
            open_.append(target)
        elif kind == "reverse":
            open_.pop()
        elif target in open_:
            back.append((source, target))
    ways.remove_edges_from(back)
    rank: dict[str, int] = {}
    for name in nx.topological_sort(ways):
        rank[name] = max((rank[before] + 1 for before in ways.predecessors(name)), default=0)
    return rank


def _chain(number: int, line: Line, rank: Mapping[str, int]) -> list[tuple[str, int]]:
    """The line's ends and, in the layers between, names for the places where it passes."""
    first, last = rank[line.source], rank[line.target]
    step = 1 if last > first else -1
    passed = [(f"\0{number} {layer}", layer) for layer in range(first + step, last, step)]
    return [(line.source, first), *passed, (line.target, last)]


def _sorted(rows: list[list[str]], near: nx.DiGraph[str], network: ActionNetwork) -> dict[str, float]:
    """Sort the rows; where everything stands across."""
    across: dict[str, float] = {}
    for row in rows:
        across |= _across(row, network)
    for sweep in range(SWEEPS):
        downwards = sweep % 2 == 0
        for row in rows if downwards else reversed(rows):
            mean = {name: _mean(name, near, across, downwards=downwards) for name in row}
            row.sort(key=mean.__getitem__)
            across |= _across(row, network)
    return across


def _mean(name: str, near: nx.DiGraph[str], across: Mapping[str, float], *, downwards: bool) -> float:
    found = [across[each] for each in (near.predecessors(name) if downwards else near.successors(name))]
    return sum(found) / len(found) if found else across[name]


def _across(row: Sequence[str], network: ActionNetwork) -> dict[str, float]:
    """Where the members of a row stand, side by side about the middle."""
    widths = [BOX if name in network.situations else LANE for name in row]
    left = -0.5 * (sum(widths) + GAP * (len(row) - 1))
    placed = {}
    for name, width in zip(row, widths, strict=True):
        placed[name] = left + 0.5 * width
        left += width + GAP
    return placed
