"""Copying the repeated parts of a network for each of their elements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from .repetition import Element, Repetition, outermost_first
from .task_model import ActionEntry, GivenFact


@dataclass(frozen=True)
class Copied:
    """An action as it will stand in the network: one of the file's, for one element or for none."""

    source: str
    target: str
    on_fail: str | None
    entry: int | None
    """Which of the file's actions; None: a skip."""
    element: Element | None = None
    """None: it stands outside the repeated parts."""


@dataclass(frozen=True)
class Copies:
    """A network's situations and actions after copying."""

    situations: Mapping[str, tuple[str, Element | None]]
    """By name: what the file calls it, and the element that it belongs to."""
    actions: tuple[Copied, ...]
    start: str


def repeated(
    situations: Mapping[str, Mapping[str, GivenFact]],
    entries: Mapping[int, ActionEntry],
    start: str,
    parts: Sequence[Repetition],
) -> Copies:
    """A network with a copy of each part for each of its elements.

    They are chained: one element's goal is the next one's start, and a part's goal may be another's start.
    Parts within a part are copied in each of its copies.

    Args:
        situations: the file's, by name, with their facts.
        entries: the file's actions, by number.
        start: where the task begins.
        parts: no two have a situation in common, unless one is within the other; each is entered at its
            start only.

    Raises:
        UnknownElement: a part goes over a list of an element around it, and there is none.
    """
    actions = (Copied(entry.source, entry.target, entry.on_fail, number) for number, entry in entries.items())
    network = Copies({name: (name, None) for name in situations}, tuple(actions), start)
    return _with_copies(network, situations, parts)


def _with_copies(
    network: Copies, facts: Mapping[str, Mapping[str, GivenFact]], parts: Iterable[Repetition]
) -> Copies:
    ahead = list(outermost_first(parts))
    while ahead:
        (part, within), *ahead = ahead
        copier = _Copier(network, facts, part)
        network = copier.copies()
        network = _with_copies(network, facts, [own for each in within for own in copier.parts(each)])
        ahead = [(copier.ending(each), [copier.ending(one) for one in inside]) for each, inside in ahead]
    return network


class _Copier:
    """Copies one part of a network in which those around it are copied already."""

    def __init__(
        self, network: Copies, facts: Mapping[str, Mapping[str, GivenFact]], part: Repetition
    ) -> None:
        self._network, self._facts, self._part = network, facts, part
        self._elements = part.elements

    def copies(self) -> Copies:
        actions = [copied for action in self._network.actions for copied in self._action(action)]
        if self._part.repeat.unfinished == "skip":
            actions += self._skips()
        return Copies(dict(self._situations()), tuple(actions), self._entered(self._network.start))

    def parts(self, within: Repetition) -> Iterator[Repetition]:
        """A part within this one, in each of the copies."""
        for each in self._elements:
            yield replace(
                within,
                start=self._part.of(within.start, each.number),
                goal=self._after(within.goal, each),
                inner=frozenset(self._part.of(name, each.number) for name in within.inner),
                around=each,
            )

    def ending(self, other: Repetition) -> Repetition:
        """Another part, whose goal may be this one's start."""
        return replace(other, goal=self._entered(other.goal))

    def _situations(self) -> Iterator[tuple[str, tuple[str, Element | None]]]:
        part = self._part
        for name, (called, element) in self._network.situations.items():
            if name in part.inner:
                yield from ((part.of(name, each.number), (called, each)) for each in self._elements)
            if name not in part.inner or name == part.goal:
                yield name, (called, element)

    def _action(self, action: Copied) -> Iterator[Copied]:
        part, fail = self._part, action.on_fail
        if action.source not in part.inner:
            yield replace(action, target=self._entered(action.target), on_fail=fail and self._entered(fail))
            return
        for each in self._elements:
            source, target = part.of(action.source, each.number), self._after(action.target, each)
            # Where start and goal are one, a Fail leads back to the element's own start.
            back = fail in part.inner
            on_fail = fail and (part.of(fail, each.number) if back else self._after(fail, each))
            yield Copied(source, target, on_fail, action.entry, each)

    def _skips(self) -> Iterator[Copied]:
        """Ways to the next element from where the robot stands as at the part's start."""
        part, situations = self._part, self._network.situations
        facts = {name: self._facts[called] for name, (called, _) in situations.items()}
        alike = [name for name in situations if name in part.inner and facts[name] == facts[part.start]]
        for each in self._elements:
            target = self._after(part.goal, each)
            yield from (Copied(part.of(name, each.number), target, None, None, each) for name in alike)

    def _entered(self, name: str) -> str:
        """Where what leads to `name` from outside of the part leads to: the first element's copy."""
        return self._part.of(name, 0) if name in self._part.inner else name

    def _after(self, name: str, element: Element) -> str:
        """Where what leads to `name` from inside the part leads to: at its goal, to what comes next."""
        part = self._part
        if name != part.goal:
            return part.of(name, element.number) if name in part.inner else name
        return name if element is self._elements[-1] else part.of(part.start, element.number + 1)
