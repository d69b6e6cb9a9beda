"""A part of a network that is repeated for each element of a list."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.entries.copied import Element as Element

from .task_model import ActionEntry, Each, Repeat


class NotRepeated(ValueError):
    """Error of a repeated part that cannot be copied for its elements, with the reason as message."""

    def __init__(self, message: str, part: KeyPath) -> None:
        super().__init__(message)
        self.part = part
        """Position of the part in the task's document."""


class UnknownElement(LookupError):
    """Error for a reference `{each: NAME.KEY}` in a task's file to an unknown element of a list, or to a key
    that the element lacks; the message names the known ones.
    """


def found_in(each: str, element: Element | None) -> tuple[KeyPath, Any]:
    """Return key path and value of the element of a list to which a reference such as `{each: NAME.KEY}`
    refers.

    NAME is the name that a task's file gives to the elements of a list over which it repeats actions.

    Raises:
        UnknownElement: no surrounding list has an element of that name, or the element has no such key.
    """
    known = {} if element is None else {one.name: one for one in element.chain()}
    name, *keys = each.split(".")
    if name not in known:
        allowed = " or ".join(f"{one}, {one}.KEY with a key of each element" for one in known)
        how = f"allowed: {allowed}" if known else "no repeat here"
        raise UnknownElement(f"unknown element {each!r}; {how}")
    path, value = known[name].path, known[name].value
    for number, key in enumerate(keys):
        if not isinstance(value, Mapping) or key not in value:
            before = ".".join([name, *keys[:number]])
            there = [f"{before}.{one}" for one in value] if isinstance(value, Mapping) else [before]
            raise UnknownElement(f"unknown element {each!r}{suggest(each, there)}")
        path, value = (*path, key), value[key]
    return path, value


@dataclass(frozen=True, eq=False)
class Repetition:
    """A part of the task's network, from the situation `start` to `goal`, that is copied for each element of
    a list in the task's file.
    """

    path: KeyPath
    """Position in the task's document."""
    repeat: Repeat
    """Content of the part in the file."""
    start: str
    goal: str
    inner: frozenset[str]
    """The situations that are copied."""
    suffix: str
    """Text for people behind the names of its elements."""
    around: Element | None = None
    """The element of the surrounding part that contains this one; None for an outermost part."""

    def elements(self) -> tuple[Element, ...]:
        """Return the elements of the list that `repeat` names, in the order of the file.

        A part of the network is copied for each element.

        Raises:
            NotRepeated: `repeat` names a list in an element of a surrounding `repeat`, and that element has
                no such list.
        """
        path, values = self._over()
        before = f"{self.around.words}, " if self.around else ""
        return tuple(
            Element(
                number,
                (*path, number),
                self.repeat.name,
                value,
                f"{before}{self.repeat.name}[{number + 1}]{_shown(value)}{self.suffix}",
                self.around,
            )
            for number, value in enumerate(values)
        )

    def count(self) -> int:
        """Return the number of elements of the list that `repeat` names; the part of the network is copied
        for each.

        Raises:
            NotRepeated: `repeat` names a list in an element of a surrounding `repeat`, and that element has
                no such list.
        """
        return len(self._over()[1])

    def _over(self) -> tuple[KeyPath, Sequence[Any]]:
        over, around = self.repeat.over, self.around
        if not isinstance(over, Each):
            return (*self.path, "over"), over
        try:
            path, values = found_in(over.each, around)
        except UnknownElement as unknown:
            raise NotRepeated(str(unknown), self.path) from None
        if not isinstance(values, list) or not values:
            whose = "" if around is None else f" of {around.words}"
            raise NotRepeated(f"{over.each} is {shortened(values)}{whose}; allowed: a list", self.path)
        return path, values

    def of(self, name: str, number: int) -> str:
        """Return the name of a situation of the repeated part in the part's copy for one element.

        Args:
            name: name of the situation in the file.
            number: number, from 0, of the element in the list over which the part is repeated.
        """
        return f"{name}[{number + 1}]"


def repetitions(
    repeats: Mapping[int, Repeat], entries: Iterable[ActionEntry], outside: Collection[str] = ()
) -> list[Repetition]:
    """Return the parts of a task's network that are repeated for each element of a list, as its file states
    them.

    Args:
        repeats: entries of the file's list `repeat`, by their numbers in it.
        entries: the task's actions.
        outside: situations that belong to no repeated part although its actions may lead there; they are
            those of the file's key `otherwise`.
    """
    actions = list(entries)
    alike = Counter(repeat.name for repeat in repeats.values())
    return [
        Repetition(
            ("repeat", number),
            repeat,
            repeat.start,
            repeat.goal,
            _reached(repeat, actions, outside),
            f" from {repeat.start}" if alike[repeat.name] > 1 else "",
        )
        for number, repeat in repeats.items()
    ]


class Nested(NamedTuple):
    """A part of a task that is repeated for each element of a list, with the repeated parts inside it."""

    part: Repetition
    within: tuple[Nested, ...]


def nested(parts: Sequence[Repetition]) -> list[Nested]:
    """Return the outermost repeated parts, each with the parts inside it."""
    outer = [part for part in parts if not any(part.inner < other.inner for other in parts)]
    return [
        Nested(part, tuple(nested([other for other in parts if other.inner < part.inner]))) for part in outer
    ]


def shortened(value: object) -> str:
    """Return a value as text for a message, cut to a maximum length."""
    words = repr(value)
    return words if len(words) <= 40 else f"{words[:40]} ..."


def _shown(value: object) -> str:
    return f" ({value})" if isinstance(value, str | int | float) else ""


def _reached(repeat: Repeat, entries: Iterable[ActionEntry], outside: Collection[str]) -> frozenset[str]:
    ways: dict[str, list[str]] = {}
    for entry in entries:
        ways.setdefault(entry.source, []).extend(entry.leads_to)
    found, ahead = {repeat.start}, [repeat.start]
    while ahead:
        for name in ways.get(ahead.pop(), ()):
            if name not in found and name != repeat.goal and name not in outside:
                found.add(name)
                ahead.append(name)
    return frozenset(found)
