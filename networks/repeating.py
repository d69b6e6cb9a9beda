"""Copying a part of a network for each element of a list."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from .network import Fact
from .task_model import ActionEntry, Repeat


@dataclass(frozen=True)
class Copied:
    """An action as it will stand in the network: one of the file's, for one element or for none."""

    source: str
    target: str
    on_fail: str | None
    entry: int | None
    """Which of the file's actions; None: a skip."""
    element: int | None
    """Which element, from 0; None: it stands outside the repeated part."""


@dataclass(frozen=True)
class Copies:
    """A network's situations and actions after copying."""

    situations: Mapping[str, tuple[Mapping[str, Fact], int | None]]
    """By name: facts, and the element that it belongs to."""
    actions: tuple[Copied, ...]
    start: str


class Repetition:
    """The part that is repeated: what `start` leads to, up to `goal`."""

    def __init__(self, repeat: Repeat, entries: Mapping[int, ActionEntry]) -> None:
        self.repeat = repeat
        self.inner = _reached(repeat, entries.values())
        self._last = len(repeat.over) - 1

    def first(self, name: str) -> str:
        """What an action from outside that leads to `name` leads to."""
        into_part = name == self.repeat.start and name != self.repeat.goal
        return self.of(name, 0) if into_part else name

    def of(self, name: str, element: int) -> str:
        """The element's own copy of a situation of the part."""
        return f"{name}[{element + 1}]" if name in self.inner else name

    def after(self, name: str, element: int) -> str:
        """Where an action of the part that leads to `name` leads to."""
        if name != self.repeat.goal:
            return self.of(name, element)
        return name if element == self._last else self.of(self.repeat.start, element + 1)

    def name(self, element: int) -> str:
        """What people read of an element: `place[2] (kitchen)`."""
        value = self.repeat.over[element]
        told = f" ({value})" if isinstance(value, str | int | float) else ""
        return f"{self.repeat.name}[{element + 1}]{told}"

    def elements(self) -> range:
        """The numbers of the elements, from 0."""
        return range(self._last + 1)


def once(
    situations: Mapping[str, Mapping[str, Fact]], entries: Mapping[int, ActionEntry], start: str
) -> Copies:
    """A network in which nothing is repeated."""
    actions = (Copied(e.source, e.target, e.on_fail, n, None) for n, e in entries.items())
    return Copies({name: (facts, None) for name, facts in situations.items()}, tuple(actions), start)


def repeated(
    situations: Mapping[str, Mapping[str, Fact]],
    entries: Mapping[int, ActionEntry],
    start: str,
    part: Repetition,
) -> Copies:
    """A network with a copy of the part for each element, chained: one's goal is the next one's start."""
    copies: dict[str, tuple[Mapping[str, Fact], int | None]] = {}
    for name, facts in situations.items():
        if name in part.inner:
            copies.update({part.of(name, element): (facts, element) for element in part.elements()})
        if name not in part.inner or name == part.repeat.goal:
            copies[name] = (facts, None)
    actions: list[Copied] = []
    for number, entry in entries.items():
        if entry.source in part.inner:
            actions += [_copy(number, entry, part, element) for element in part.elements()]
        if entry.source not in part.inner:
            on_fail = entry.on_fail and part.first(entry.on_fail)
            actions.append(Copied(entry.source, part.first(entry.target), on_fail, number, None))
    if part.repeat.unfinished == "skip":
        actions += _skips(situations, part)
    begin = part.of(start, 0) if start == part.repeat.start else start
    return Copies(copies, tuple(actions), begin)


def entered_elsewhere(entries: Mapping[int, ActionEntry], part: Repetition) -> list[tuple[int, str]]:
    """Actions from outside that lead into the part past its start: number and key in the file."""
    inside = part.inner - {part.repeat.start}
    return [
        (number, key)
        for number, entry in entries.items()
        if entry.source not in part.inner
        for key, name in (("to", entry.target), ("on_fail", entry.on_fail))
        if name in inside
    ]


def _copy(number: int, entry: ActionEntry, part: Repetition, element: int) -> Copied:
    on_fail = entry.on_fail and part.of(entry.on_fail, element)
    return Copied(part.of(entry.source, element), part.after(entry.target, element), on_fail, number, element)


def _skips(situations: Mapping[str, Mapping[str, Fact]], part: Repetition) -> Sequence[Copied]:
    """Ways to the next element from where the robot stands as at the part's start."""
    facts = situations.get(part.repeat.start)
    alike = [name for name in situations if name in part.inner and situations[name] == facts]
    return [
        Copied(part.of(name, element), part.after(part.repeat.goal, element), None, None, element)
        for element in part.elements()
        for name in alike
    ]


def _reached(repeat: Repeat, entries: Iterable[ActionEntry]) -> frozenset[str]:
    ways: dict[str, list[str]] = {}
    for entry in entries:
        ways.setdefault(entry.source, []).extend(filter(None, (entry.target, entry.on_fail)))
    found, ahead = {repeat.start}, [repeat.start]
    while ahead:
        for name in ways.get(ahead.pop(), ()):
            if name not in found and name != repeat.goal:
                found.add(name)
                ahead.append(name)
    return frozenset(found)
