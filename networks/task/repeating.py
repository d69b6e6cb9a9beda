"""Copying the repeated parts of a network for each of their elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from handcart.networks.graph.network import Fact

from .repetition import Element, Repetition
from .task_model import ActionEntry


@dataclass(frozen=True)
class Copied:
    """An action as it will stand in the network: one of the file's, for one element or for none."""

    source: str
    target: str
    on_fail: str | None
    entry: int | None
    """Which of the file's actions; None: a skip."""
    element: Element | None
    """None: it stands outside the repeated parts."""


@dataclass(frozen=True)
class Copies:
    """A network's situations and actions after copying."""

    situations: Mapping[str, tuple[Mapping[str, Fact], Element | None]]
    """By name: facts, and the element that it belongs to."""
    actions: tuple[Copied, ...]
    start: str


def repeated(
    situations: Mapping[str, Mapping[str, Fact]],
    entries: Mapping[int, ActionEntry],
    start: str,
    parts: Sequence[Repetition],
) -> Copies:
    """A network with a copy of each part for each of its elements.

    They are chained: one element's goal is the next one's start, and a part's goal may be another's start.

    Args:
        situations: the file's, by name, with their facts.
        entries: the file's actions, by number.
        start: where the task begins.
        parts: no two with a situation in common, entered at their starts only.
    """
    return _Copier(situations, entries, parts).copies(start)


class _Copier:
    """Knows which part each situation is in."""

    def __init__(
        self,
        situations: Mapping[str, Mapping[str, Fact]],
        entries: Mapping[int, ActionEntry],
        parts: Sequence[Repetition],
    ) -> None:
        self._situations = situations
        self._entries = entries
        self._parts = parts
        self._around = {name: part for part in parts for name in part.inner}

    def copies(self, start: str) -> Copies:
        actions = [
            copied for number, entry in self._entries.items() for copied in self._action(number, entry)
        ]
        for part in self._parts:
            if part.repeat.unfinished == "skip":
                actions += self._skips(part)
        return Copies(dict(self._copied_situations()), tuple(actions), self._entered(start))

    def _copied_situations(self) -> Iterator[tuple[str, tuple[Mapping[str, Fact], Element | None]]]:
        for name, facts in self._situations.items():
            part = self._around.get(name)
            if part:
                yield from ((part.of(name, each.number), (facts, each)) for each in part.elements)
            if not part or name == part.repeat.goal:
                yield name, (facts, None)

    def _action(self, number: int, entry: ActionEntry) -> Iterator[Copied]:
        part, fail = self._around.get(entry.source), entry.on_fail
        if not part:
            on_fail = fail and self._entered(fail)
            yield Copied(entry.source, self._entered(entry.target), on_fail, number, None)
            return
        for each in part.elements:
            source, target = part.of(entry.source, each.number), self._after(entry.target, part, each)
            # Where start and goal are one, a Fail leads back to the element's own start.
            back = fail in part.inner
            on_fail = fail and (part.of(fail, each.number) if back else self._after(fail, part, each))
            yield Copied(source, target, on_fail, number, each)

    def _skips(self, part: Repetition) -> Iterator[Copied]:
        """Ways to the next element from where the robot stands as at the part's start."""
        facts = self._situations.get(part.repeat.start)
        alike = [name for name in self._situations if name in part.inner and self._situations[name] == facts]
        for each in part.elements:
            target = self._after(part.repeat.goal, part, each)
            yield from (Copied(part.of(name, each.number), target, None, None, each) for name in alike)

    def _entered(self, name: str) -> str:
        """Where what leads to `name` from outside of its part leads to: the first element's copy."""
        part = self._around.get(name)
        return part.of(name, 0) if part else name

    def _after(self, name: str, part: Repetition, element: Element) -> str:
        """Where what leads to `name` from inside the part leads to: at its goal, to what comes next."""
        if name != part.repeat.goal:
            return part.of(name, element.number)
        if element is not part.elements[-1]:
            return part.of(part.repeat.start, element.number + 1)
        return name if name in part.inner else self._entered(name)
