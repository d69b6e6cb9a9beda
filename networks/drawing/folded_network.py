"""A network whose copies of a repeated part are folded into one."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import networkx as nx

from handcart.networks.graph.network import Action, ActionNetwork, Situation

MAX_LINE_CHARS = 40


@dataclass(frozen=True)
class Spot:
    """Situation in a drawing of a network; it stands for one situation, or for all copies made of it by
    `repeat`.
    """

    name: str
    """Name as written in the file."""
    depth: int
    """Number of repeated parts around it."""
    members: tuple[str, ...]
    facts: tuple[str, ...]
    """`key: value` of each fact; if copies differ, their first and last value."""


@dataclass(frozen=True)
class FoldedAction:
    """Action in a drawing of a network; it stands for one action, or for all copies made of it by
    `repeat`.
    """

    source: Spot
    target: Spot
    on_fail: Spot | None
    fails: tuple[tuple[str, Spot], ...]
    """Situations that Fails of named causes lead to, by cause."""
    do: str
    members: tuple[int, ...]
    """Numbers of the actions in the network."""
    costs: str
    """Its cost in words, and whether a person has to permit it."""
    parameters: tuple[str, ...]
    """`name: value` of each parameter; if copies differ, their first and last value."""


@dataclass(frozen=True, eq=False)
class RepeatedPart:
    """Part of the network that exists once for each element of a `repeat` (a list in the task file), drawn
    only once, in a frame.
    """

    title: str
    """Title that names the repeated elements."""
    around: RepeatedPart | None
    """Part that contains this one; None for an outermost part."""


@dataclass(frozen=True)
class FoldedNetwork:
    """A network prepared for drawing, in which the copies of a repeated part are drawn as one."""

    spots: tuple[Spot, ...]
    ways: tuple[FoldedAction, ...]
    parts: tuple[RepeatedPart, ...]
    """Repeated parts, each after the one that contains it."""
    part_of: Mapping[Spot, RepeatedPart | None]
    start: Spot
    goal: Spot

    def spot(self, situation: str) -> Spot:
        """Return the drawn situation (spot) that contains a situation of the network, given by its name."""
        return next(item for item in self.spots if situation in item.members)


def fold(network: ActionNetwork) -> FoldedNetwork:
    """Return the network in which the copies of a situation or action made by `repeat` are merged into
    one.
    """
    copies: dict[tuple[str, int], list[Situation]] = {}
    for situation in network.situations.values():
        copies.setdefault(_called(situation), []).append(situation)
    spots = {
        (name, depth): Spot(name, depth, tuple(item.name for item in every), _merged(e.facts for e in every))
        for (name, depth), every in copies.items()
    }
    of = {situation.name: spots[_called(situation)] for situation in network.situations.values()}
    parts = _parts(network, of)
    ways = tuple(_way(every, of) for every in _alike(network, of))
    around = {spot: parts.get(network.situations[spot.members[0]].element or "") for spot in spots.values()}
    listed = sorted(dict.fromkeys(parts.values()), key=_depth)
    return FoldedNetwork(
        tuple(spots.values()), ways, tuple(listed), around, of[network.start], of[network.goal]
    )


def _called(situation: Situation) -> tuple[str, int]:
    """Return a situation's name in the file, and how many repeated parts it is in."""
    if situation.element is None:
        return situation.name, 0
    name = re.sub(r"(\[\d+\])+$", "", situation.name)
    return name, situation.name.count("[", len(name))


def _alike(network: ActionNetwork, of: Mapping[str, Spot]) -> Iterable[list[Action]]:
    """Return the actions grouped by copies: those at the same position out of copies of one situation."""
    passed: Counter[str] = Counter()
    alike: dict[tuple[Spot, int], list[Action]] = {}
    for action in network.actions:
        alike.setdefault((of[action.source], passed[action.source]), []).append(action)
        passed[action.source] += 1
    return alike.values()


def _way(copies: Sequence[Action], of: Mapping[str, Spot]) -> FoldedAction:
    last = copies[-1]  # it leads out of the part, the others to the next element
    words = [f"{last.cost_s:g} s"] if last.binding else []
    if last.permit:
        words.append("operator permits")
    if last.time_out_s is not None:
        words.append(f"at most {last.time_out_s:g} s")
    return FoldedAction(
        of[last.source],
        of[last.target],
        of[last.on_fail] if last.on_fail else None,
        tuple((ending.cause, of[ending.target]) for ending in last.fail_endings if ending.target),
        last.do,
        tuple(copy.index for copy in copies),
        ", ".join(words),
        _merged(copy.binding.given() if copy.binding else {} for copy in copies),
    )


def _merged(rows: Iterable[Mapping[str, Any]]) -> tuple[str, ...]:
    """Return `key: value` of each key; where values differ, the first and the last."""
    values: dict[str, list[str]] = {}
    every = list(rows)
    for row in every:
        for key, value in row.items():
            if value is not None:
                values.setdefault(key, []).append(_said(value))
    lines = []
    for key, said in values.items():
        words = said[0] if len(set(said)) == 1 else f"{said[0]} … {said[-1]}"
        lines.append(shortened(f"{key}: {words}{' for some' if len(said) < len(every) else ''}"))
    return tuple(lines)


def _said(value: object) -> str:
    if isinstance(value, Mapping) and set(value) == {"model"}:
        return str(value["model"])
    return str(value).lower() if isinstance(value, bool) else str(value)


def shortened(words: str) -> str:
    """Return a line of text for a drawing, cut to `MAX_LINE_CHARS` characters if it is longer.

    Line breaks become spaces, and other characters that no file of XML may hold a replacement character.
    """
    line = "".join(letter if letter.isprintable() else "\ufffd" for letter in " ".join(words.split()))
    return line if len(line) <= MAX_LINE_CHARS else f"{line[: MAX_LINE_CHARS - 1]}…"


def _parts(network: ActionNetwork, of: Mapping[str, Spot]) -> dict[str, RepeatedPart]:
    """Return the part of each element, by the element's words."""
    joined: nx.Graph[Any] = nx.Graph()
    for situation in network.situations.values():
        if situation.element is not None:
            joined.add_edge(of[situation.name], situation.element)
    groups = [[item for item in group if isinstance(item, str)] for group in nx.connected_components(joined)]
    order = {situation.element: number for number, situation in enumerate(network.situations.values())}
    parts: dict[str, RepeatedPart] = {}
    for group in sorted(groups, key=lambda words: min(len(word) for word in words)):
        elements = sorted(group, key=order.__getitem__)
        outer = max((one for one in parts if elements[0].startswith(f"{one}, ")), key=len, default="")
        part = RepeatedPart(_title(elements, len(outer)), parts.get(outer))
        parts |= dict.fromkeys(elements, part)
    return parts


_ELEMENT = re.compile(r"(?:, )?(?P<name>.*?)\[\d+\](?: \((?P<value>.*)\))?")


def _title(elements: Sequence[str], outer: int) -> str:
    """Return a title with the name, number and values of the elements."""
    found = [_ELEMENT.match(words[outer:]) for words in elements]
    if not all(found):
        return f"{len(elements)} times"
    values = [one["value"] for one in found if one and one["value"] is not None]
    listed = ", ".join(values)
    if len(listed) > MAX_LINE_CHARS:
        first = ", ".join(values[:2])
        listed = shortened(f"{first} … {values[-1]}" if len(values) > 2 else first)
    times = f"{len(elements)} time{'' if len(elements) == 1 else 's'}{' in all' if outer else ''}"
    assert found[0] is not None
    return f"for each {found[0]['name']}, {times}" + (f": {listed}" if values else "")


def _depth(part: RepeatedPart) -> int:
    return 0 if part.around is None else 1 + _depth(part.around)
