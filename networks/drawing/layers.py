"""Placing boxes in columns, so that most links lead to the right and none through a box.

Source: Sugiyama, Tagawa and Toda, Methods for visual understanding of hierarchical systems (1981).
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import networkx as nx

GAP, DOWN, LANE = 46.0, 16.0, 12.0  # between columns; between boxes; of a passing link; in [px]
SORTING_SWEEPS = 12  # times that the columns are sorted by their neighbours, to the right and back
LANE_WEIGHT = 6.0  # how much straighter a passing link is to be than one at a box
Key = Hashable


class Size(NamedTuple):
    """Size of a box in a drawing of a network, in [px], and the height at which links enter it."""

    width: float
    height: float
    enter: float
    """Distance below the box's upper edge at which links arrive at its left edge, in [px]."""


class LayerEdge(NamedTuple):
    """Link in a drawing of a network, from the right edge of one box to the left edge of another box."""

    source: Key
    target: Key
    leave: float
    """Distance below the source's upper edge at which the edge leaves, in [px]."""


class Point(NamedTuple):
    """A point in a drawing, in [px] from its upper left corner; y points down."""

    x: float
    y: float


class Layers(NamedTuple):
    """Positions of all boxes and edges of a drawing, in which edges lead from column to column."""

    width: float
    """Width in [px], with half a gap on the left and on the right."""
    height: float
    corners: Mapping[Key, Point]
    """The upper left corner of each box."""
    routes: Sequence[Sequence[Point]]
    """Points of each edge: point 0 to 1 is straight, 1 to 2 curved, 2 to 3 straight, and so on."""


class _Lane(NamedTuple):
    """A point in a column through which an edge passes."""

    edge: int
    column: int


def lay_out(boxes: Mapping[Key, Size], edges: Sequence[LayerEdge], first: Key) -> Layers:
    """Return positions of all boxes and edges of a drawn network.

    Args:
        boxes: sizes of the boxes, by their keys.
        edges: edges between the boxes.
        first: key of the first box, such as a network's start; an edge that leads back to it is drawn against
            the direction of the other edges.
    """
    rank = _ranks(boxes, edges, first)
    columns: list[list[Key]] = [[] for _ in range(max(rank.values()) + 1)]
    for key in boxes:
        columns[rank[key]].append(key)
    chains = [_chain(number, edge, rank) for number, edge in enumerate(edges)]
    for lane in (cell for chain in chains for cell in chain if isinstance(cell, _Lane)):
        columns[lane.column].append(lane)
    sizes = {
        **boxes,
        **{c: Size(0.0, LANE, LANE / 2) for column in columns for c in column if c not in boxes},
    }
    placing = _Placing(columns, sizes, edges, chains)
    tops = placing.tops()
    lowest = min(tops.values())
    lefts, x = [], GAP / 2
    widths = [max(sizes[cell].width for cell in column) for column in columns]
    for width in widths:
        lefts.append(x)
        x += width + GAP
    corners = {
        key: Point(lefts[rank[key]] + 0.5 * (widths[rank[key]] - size.width), tops[key] - lowest)
        for key, size in boxes.items()
    }
    across = [(left, left + width) for left, width in zip(lefts, widths, strict=True)]
    height = max(tops[cell] + sizes[cell].height for cell in tops) - lowest
    routes = []
    for edge, chain in zip(edges, chains, strict=True):
        begin, end = corners[edge.source], corners[edge.target]
        lanes = [
            (across[item.column], tops[item] - lowest + LANE / 2) for item in chain if isinstance(item, _Lane)
        ]
        leave = Point(begin.x + boxes[edge.source].width, begin.y + edge.leave)
        arrive = Point(end.x, end.y + boxes[edge.target].enter)
        back = rank[edge.target] <= rank[edge.source]
        passed = [Point(x, y) for span, y in lanes for x in (reversed(span) if back else span)]
        outer = Point(across[rank[edge.source]][1], leave.y), Point(across[rank[edge.target]][0], arrive.y)
        routes.append([leave, outer[0], *passed, outer[1], arrive])
    return Layers(x - GAP / 2, height, corners, routes)


def _ranks(boxes: Mapping[Key, Size], edges: Sequence[LayerEdge], first: Key) -> dict[Key, int]:
    """Return the column of each box: longest ways from the first, without those that close a circle."""
    ways: nx.DiGraph[Key] = nx.DiGraph()
    ways.add_nodes_from([first, *boxes])
    ways.add_edges_from((edge.source, edge.target) for edge in edges if edge.source != edge.target)
    open_: list[Key] = []
    back = []
    for source, target, kind in nx.dfs_labeled_edges(ways):
        if kind == "forward":
            open_.append(target)
        elif kind == "reverse":
            open_.pop()
        elif target in open_:
            back.append((source, target))
    ways.remove_edges_from(back)
    rank: dict[Key, int] = {}
    for key in nx.topological_sort(ways):
        rank[key] = max((rank[before] + 1 for before in ways.predecessors(key)), default=0)
    return rank


def _chain(number: int, edge: LayerEdge, rank: Mapping[Key, int]) -> list[Key]:
    """Return the ends of an edge, and between them its lanes, one in each column that it passes."""
    a, b = rank[edge.source], rank[edge.target]
    passed = range(a + 1, b) if b > a else range(a, b - 1, -1)
    return [edge.source, *(_Lane(number, column) for column in passed), edge.target]


class _Placing:
    """Vertical arrangement of the cells, by their order within each column and by position."""

    def __init__(
        self,
        columns: list[list[Key]],
        sizes: Mapping[Key, Size],
        edges: Sequence[LayerEdge],
        chains: Sequence[Sequence[Key]],
    ) -> None:
        self._columns, self._sizes = columns, sizes
        self._near: dict[Key, list[tuple[Key, float, float, float]]] = {cell: [] for cell in sizes}
        """Neighbours of each cell: key, distance below its upper edge, below the neighbour's, weight."""
        for edge, chain in zip(edges, chains, strict=True):
            for a, b in pairwise(chain):
                out = edge.leave if a == edge.source else LANE / 2
                weight = LANE_WEIGHT if isinstance(a, _Lane) and isinstance(b, _Lane) else 1.0
                self._near[a].append((b, out, sizes[b].enter, weight))
                self._near[b].append((a, sizes[b].enter, out, weight))
        self._column = {cell: number for number, column in enumerate(columns) for cell in column}

    def tops(self) -> dict[Key, float]:
        """Return the upper edge of each cell."""
        tops: dict[Key, float] = {}
        for column in self._columns:
            tops |= self._placed(column, dict.fromkeys(column, 0.0))
        for sort in (True, False):
            for sweep in range(SORTING_SWEEPS):
                right = sweep % 2 == 0
                for column in self._columns if right else reversed(self._columns):
                    # At last both sides count, so that no column leans to one of them.
                    sides = ((-1, 0) if right else (1, 0)) if sort else (-1, 0, 1)
                    wanted = {cell: self._wanted(cell, tops, sides) for cell in column}
                    if sort:
                        column.sort(key=lambda cell: wanted[cell] + 0.5 * self._sizes[cell].height)
                    tops |= self._placed(column, wanted)
        return tops

    def _wanted(self, cell: Key, tops: Mapping[Key, float], sides: Sequence[int]) -> float:
        here = self._column[cell]
        near = [row for row in self._near[cell] if self._column[row[0]] - here in sides]
        if not near:
            return tops[cell]
        weights = sum(weight for *_, weight in near)
        return sum(weight * (tops[key] + theirs - own) for key, own, theirs, weight in near) / weights

    def _placed(self, column: Sequence[Key], wanted: Mapping[Key, float]) -> dict[Key, float]:
        """Return positions as near as possible to the wanted ones, one cell below the other."""
        down, steps = 0.0, []
        for cell in column:
            steps.append(down)
            down += self._sizes[cell].height + DOWN
        rising = _rising([wanted[cell] - step for cell, step in zip(column, steps, strict=True)])
        return {cell: y + step for cell, y, step in zip(column, rising, steps, strict=True)}


def _rising(values: Sequence[float]) -> list[float]:
    """Return the nearest values of which none is below the one before (pool adjacent violators)."""
    pools: list[tuple[float, int]] = []
    for value in values:
        pool = (value, 1)
        while pools and pools[-1][0] > pool[0]:
            mean, count = pools.pop()
            pool = ((mean * count + pool[0] * pool[1]) / (count + pool[1]), count + pool[1])
        pools.append(pool)
    return [mean for mean, count in pools for _ in range(count)]
