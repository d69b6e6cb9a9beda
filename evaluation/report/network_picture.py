"""A run's network from left to right: what was travelled, what failed, what was never tried; repeats folded.

Actions stand in columns of their own between those of situations, so that no label can lie over another.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import networkx as nx

from handcart.networks.graph.network import ActionNetwork
from handcart.networks.journal.past_run import PastAction

LETTER = 7.4  # width of the widest usual letter at 12 px, all in [px]
HEIGHT, ACROSS, DOWN, MARGIN, LEAST = 40.0, 34.0, 14.0, 12.0, 60.0


class Way(NamedTuple):
    """An action, or all copies of it that a repeat made."""

    source: str
    target: str
    do: str


class Box(NamedTuple):
    """A situation or an action on the paper; x and y are its upper left corner, in [px]."""

    x: float
    y: float
    width: float
    height: float
    kind: str
    """`situation`, or what became of an action: `travelled`, `failed`, `mixed`, `untried`."""
    words: str
    below: str
    way: Way | None = None
    """Which action it is; None: a situation."""


class Link(NamedTuple):
    """A line between two boxes, from right edge to left edge."""

    path: str
    travelled: bool


@dataclass(frozen=True)
class NetworkPicture:
    """A drawn network."""

    width: float
    """[px]"""
    height: float
    """[px]"""
    boxes: Sequence[Box]
    links: Sequence[Link]


def folded(name: str) -> str:
    """A situation's name without the number of its element: all copies of a repeat are one."""
    return re.sub(r"\[\d+\]", "", name)


def draw_network(network: ActionNetwork, actions: Sequence[PastAction]) -> NetworkPicture:
    """Lay a network out.

    Args:
        network: as the journal kept it.
        actions: those of the run.
    """
    ways = list(dict.fromkeys(Way(folded(a.source), folded(a.target), a.do) for a in network.actions))
    done = Counter((Way(folded(a.source), folded(a.target), a.do), a.outcome) for a in actions)
    columns = _columns(ways, folded(network.start))
    size = {each: _size(each, done) for column in columns for each in column}
    corner, height = _placed(columns, size)
    boxes = [
        Box(
            *corner[each],
            *size[each],
            _kind(each, done),
            _words(each),
            _below(each, done),
            each if isinstance(each, Way) else None,
        )
        for each in corner
    ]
    links = []
    for way in ways:
        # A Fail leaves the situation as it was: only a Success has come to the target.
        came, went = done[way, "Success"] > 0, any(done[way, end] for end in _ENDS)
        links.append(Link(_curve(corner, size, way.source, way), went))
        links.append(Link(_curve(corner, size, way, way.target), came))
    width = max(box.x + box.width for box in boxes) + MARGIN
    return NetworkPicture(width, height, boxes, links)


def _columns(ways: Sequence[Way], start: str) -> list[list[str | Way]]:
    """Situations by their distance from the start, each way in the column right of its source."""
    graph: nx.DiGraph[str] = nx.DiGraph([(way.source, way.target) for way in ways])
    graph.add_node(start)
    depth = nx.single_source_shortest_path_length(graph, start)
    far = max(depth.values()) + 1
    columns: list[list[str | Way]] = [[] for _ in range(2 * far + 2)]
    for name in graph:
        columns[2 * depth.get(name, far)].append(name)
    for way in ways:
        columns[2 * depth.get(way.source, far) + 1].append(way)
    above: dict[str | Way, float] = {}
    for number, column in enumerate(columns):
        if number:
            column.sort(key=lambda each: _mean(each, ways, above))
        above |= {each: float(row) - 0.5 * len(column) for row, each in enumerate(column)}
    return [column for column in columns if column]


def _mean(each: str | Way, ways: Sequence[Way], above: Mapping[str | Way, float]) -> float:
    before = [each.source] if isinstance(each, Way) else [way for way in ways if way.target == each]
    rows = [above[one] for one in before if one in above]
    return sum(rows) / len(rows) if rows else 0.0


def _placed(
    columns: Sequence[Sequence[str | Way]], size: Mapping[str | Way, tuple[float, float]]
) -> tuple[dict[str | Way, tuple[float, float]], float]:
    """The upper left corner of each box, and the paper's height."""
    highest = max(len(column) for column in columns)
    height = 2 * MARGIN + highest * (HEIGHT + DOWN) - DOWN
    corner: dict[str | Way, tuple[float, float]] = {}
    x = MARGIN
    for column in columns:
        wide = max(size[each][0] for each in column)
        y = 0.5 * (height - len(column) * (HEIGHT + DOWN) + DOWN)
        for each in column:
            corner[each] = (x + 0.5 * (wide - size[each][0]), y)
            y += HEIGHT + DOWN
        x += wide + ACROSS
    return corner, height


def _size(each: str | Way, done: Counter[tuple[Way, str]]) -> tuple[float, float]:
    longest = max(len(_words(each)), len(_below(each, done)))
    return max(LEAST, LETTER * longest + 16.0), HEIGHT


def _words(each: str | Way) -> str:
    return each.do if isinstance(each, Way) else each


def _below(each: str | Way, done: Counter[tuple[Way, str]]) -> str:
    if not isinstance(each, Way):
        return ""
    told = [f"{done[each, end]} {words}" for end, words in _ENDS.items() if done[each, end]]
    return ", ".join(told) or "not tried"


_ENDS = {"Success": "Success", "Fail": "Fail", "GiveUp": "GiveUp", "": "no end"}


def _kind(each: str | Way, done: Counter[tuple[Way, str]]) -> str:
    if not isinstance(each, Way):
        return "situation"
    went = done[each, "Success"] > 0
    failed = sum(done[each, end] for end in ("Fail", "GiveUp", "")) > 0
    return "mixed" if went and failed else "travelled" if went else "failed" if failed else "untried"


def _curve(
    corner: Mapping[str | Way, tuple[float, float]],
    size: Mapping[str | Way, tuple[float, float]],
    a: str | Way,
    b: str | Way,
) -> str:
    x0, y0 = corner[a][0] + size[a][0], corner[a][1] + 0.5 * HEIGHT
    x1, y1 = corner[b][0], corner[b][1] + 0.5 * HEIGHT
    bend = max(0.5 * (x1 - x0), ACROSS)
    return f"M{x0:.0f} {y0:.0f} C{x0 + bend:.0f} {y0:.0f} {x1 - bend:.0f} {y1:.0f} {x1:.0f} {y1:.0f}"
