"""Copying the repeated parts of a network for each of their elements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from handcart.networks.entries.copied import Copied as Copied
from handcart.networks.entries.copied import Copies as Copies
from handcart.networks.graph.network import MAX_ACTIONS

from .repetition import Element, Nested, NotRepeated, Repetition, nested
from .task_model import ActionEntry, GivenFact


def repeated(
    situations: Mapping[str, Mapping[str, GivenFact]],
    entries: Mapping[int, ActionEntry],
    start: str,
    parts: Sequence[Repetition],
) -> Copies:
    """Return a network in which each part that the task repeats for a list has one copy for each element of
    the list.

    The copies follow each other, because the goal of one element's copy is the start of the next one's. The
    goal of a part may be the start of another part. Parts within a part are copied in each of its copies.

    Args:
        situations: the file's situations, by name, with their facts.
        entries: the file's actions, by number.
        start: where the task begins.
        parts: the parts to repeat; two of them have no situation in common, unless one is within the other;
            each is entered at its start only.

    Raises:
        NotRepeated: a part iterates over a list in the surrounding part's element, and that element has no
            such list; or there would be more actions than `MAX_ACTIONS`.
    """
    actions = (_plain(number, entry) for number, entry in entries.items())
    network = Copies({name: (name, None) for name in situations}, tuple(actions), start)
    level = nested(parts)
    while level:
        copier = _Copier(network, situations, [nested_.part for nested_ in level])
        network = copier.copies()
        level = [within for nested_ in level for within in copier.within(nested_)]
    return network


def _plain(number: int, entry: ActionEntry) -> Copied:
    usual, *others = entry.endings
    nexts = tuple(other.target for other in others)
    fails = tuple(fail_entry.to for fail_entry in entry.fail_entries.values())
    return Copied(entry.source, usual.target, entry.on_fail, number, None, nexts, fails)


class _Copier:
    """Copier of parts that share no situation, in a network in which the parts around them are copied
    already.
    """

    def __init__(
        self, network: Copies, facts: Mapping[str, Mapping[str, GivenFact]], parts: Sequence[Repetition]
    ) -> None:
        self._network, self._facts, self._parts = network, facts, parts
        self._around = {name: part for part in parts for name in part.inner}
        self._check_number()
        self._elements = {part: part.elements() for part in parts}

    def copies(self) -> Copies:
        actions = [copied for action in self._network.actions for copied in self._action(action)]
        for part in self._parts:
            if part.repeat.unfinished == "skip":
                actions += self._skips(part)
        return Copies(dict(self._situations()), tuple(actions), self._entered(self._network.start))

    def _check_number(self) -> None:
        """Raise `NotRepeated` if parts within parts multiply to more than `MAX_ACTIONS` actions."""
        own = Counter(self._around.get(action.source) for action in self._network.actions)
        count = sum(times * (part.count() if part else 1) for part, times in own.items())
        if count > MAX_ACTIONS:
            most = max(self._parts, key=lambda part: own[part] * part.count())
            wrong = f"with it the network has {count} actions; allowed: at most {MAX_ACTIONS}"
            raise NotRepeated(wrong, most.path)

    def within(self, around: Nested) -> Iterator[Nested]:
        """Yield the parts within one, in each of its copies."""
        for element in self._elements[around.part]:
            for nested_ in around.within:
                yield self._copied(nested_, around.part, element)

    def _copied(self, nested: Nested, around: Repetition, element: Element) -> Nested:
        part = replace(
            nested.part,
            start=around.of(nested.part.start, element.number),
            goal=self._after(nested.part.goal, around, element),
            inner=frozenset(around.of(name, element.number) for name in nested.part.inner),
            around=element,
        )
        return Nested(part, tuple(self._copied(nested_, around, element) for nested_ in nested.within))

    def _situations(self) -> Iterator[tuple[str, tuple[str, Element | None]]]:
        for name, (called, element) in self._network.situations.items():
            part = self._around.get(name)
            if part:
                yield from ((part.of(name, item.number), (called, item)) for item in self._elements[part])
            if not part or name == part.goal:
                yield name, (called, element)

    def _action(self, action: Copied) -> Iterator[Copied]:
        part = self._around.get(action.source)
        if not part:
            others = tuple(map(self._entered, action.others))
            target, (failed, *by_cause) = self._entered(action.target), self._entered_by_fail(action)
            yield replace(action, target=target, on_fail=failed, others=others, fails=tuple(by_cause))
            return
        for item in self._elements[part]:
            source, target = part.of(action.source, item.number), self._after(action.target, part, item)
            every = (action.on_fail, *action.fails)
            on_fail, *by_cause = (self._failed(to, part, item) for to in every)
            others = tuple(self._after(other, part, item) for other in action.others)
            yield Copied(source, target, on_fail, action.entry, item, others, tuple(by_cause))

    def _entered_by_fail(self, action: Copied) -> list[str | None]:
        return [to and self._entered(to) for to in (action.on_fail, *action.fails)]

    def _failed(self, name: str | None, part: Repetition, element: Element) -> str | None:
        """Return the new situation after a Fail inside the part.

        Where start and goal are one, a Fail leads back to the element's own start.
        """
        back = name in part.inner
        return name and (part.of(name, element.number) if back else self._after(name, part, element))

    def _skips(self, part: Repetition) -> Iterator[Copied]:
        """Yield skips to the next element, from each situation with the same facts as the part's start."""
        situations = self._network.situations
        facts = {name: self._facts[situations[name][0]] for name in part.inner}
        alike = [name for name in situations if name in part.inner and facts[name] == facts[part.start]]
        for item in self._elements[part]:
            target = self._after(part.goal, part, item)
            yield from (Copied(part.of(name, item.number), target, None, None, item) for name in alike)

    def _entered(self, name: str) -> str:
        """Return the new target of an action from outside that leads to `name`: the first element's copy."""
        part = self._around.get(name)
        return part.of(name, 0) if part else name

    def _after(self, name: str, part: Repetition, element: Element) -> str:
        """Return the new target of an action inside the part that leads to `name`.

        If it leads to the part's goal, the new target is the start of the next element.
        """
        if name != part.goal:
            return part.of(name, element.number) if name in part.inner else self._entered(name)
        if element is not self._elements[part][-1]:
            return part.of(part.start, element.number + 1)
        return name if name in part.inner else self._entered(name)
