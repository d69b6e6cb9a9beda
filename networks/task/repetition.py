"""A part of a network that is there for each element of a list."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from handcart.files.yaml.yaml_node import KeyPath

from .task_model import ActionEntry, Repeat


@dataclass(frozen=True)
class Element:
    """An element of a repeated part."""

    number: int
    """Which of its part's, from 0."""
    path: KeyPath
    """Where it stands in the task's document."""
    name: str
    """What `{each: NAME}` calls it."""
    words: str
    """What people read of it, `place[2] (kitchen)`; no other element of the task has the same."""


class Repetition:
    """A part that is repeated: what `start` leads to, up to `goal`."""

    def __init__(self, path: KeyPath, repeat: Repeat, inner: frozenset[str], told: str = "") -> None:
        """A part and its elements.

        Args:
            path: where it stands in the task's document.
            repeat: what stands there.
            inner: the situations that are copied.
            told: what people read behind the names of its elements.
        """
        self.path = path
        self.repeat = repeat
        self.inner = inner
        self.elements = tuple(
            Element(number, (*path, "over", number), repeat.name, f"{_words(repeat, number)}{told}")
            for number in range(len(repeat.over))
        )

    def of(self, name: str, number: int) -> str:
        """An element's own copy of a situation of the part."""
        return f"{name}[{number + 1}]"


def repetitions(repeats: Mapping[int, Repeat], entries: Iterable[ActionEntry]) -> list[Repetition]:
    """The repeated parts of a task, by their numbers in its list."""
    actions = list(entries)
    alike = Counter(repeat.name for repeat in repeats.values())
    return [
        Repetition(
            ("repeat", number),
            repeat,
            _reached(repeat, actions),
            f" from {repeat.start}" if alike[repeat.name] > 1 else "",
        )
        for number, repeat in repeats.items()
    ]


def _words(repeat: Repeat, number: int) -> str:
    value = repeat.over[number]
    told = f" ({value})" if isinstance(value, str | int | float) else ""
    return f"{repeat.name}[{number + 1}]{told}"


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
