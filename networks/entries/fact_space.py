"""The facts of a task with the values that each may have, and what is wrong with conditions on them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from handcart.files.suggest import listed, suggest
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.graph.network import Fact

from .condition_entry import ConditionEntry, value_in_words

State = tuple[int, ...]
"""Index of the present value of each fact, the facts in the order of `FactSpace.values`."""
Condition = tuple[tuple[int, frozenset[int]], ...]
"""Pairs of a fact's number and the indices of the values that are allowed."""
Change = tuple[tuple[int, int], ...]
"""Pairs of a fact's number and the index of its new value."""
Faults = Iterator[tuple[KeyPath, str]]
RESERVED_NAMES = ("p", "result")
"""Keys of an entry of `then`, which no fact can have as its name."""


@dataclass(frozen=True)
class FactSpace:
    """Names and possible values of a task's facts; a `State` has for each fact the index of its value.

    Physical facts hold in the world; known facts only describe the robot's knowledge.
    """

    facts: Mapping[str, Sequence[Fact]]
    """Possible values of each physical fact, the first at the start."""
    known: Mapping[str, Sequence[Fact]]
    """Possible values of what the robot may know, the first at the start."""

    @cached_property
    def values(self) -> dict[str, list[Fact]]:
        """Possible values of each fact, physical facts first."""
        return {name: list(item) for name, item in (*self.facts.items(), *self.known.items())}

    @cached_property
    def number(self) -> dict[str, int]:
        """Index of each fact among all facts of the task, physical facts first, by the fact's name."""
        return {name: number for number, name in enumerate(self.values)}

    @cached_property
    def _index(self) -> list[dict[object, int]]:
        return [{_key(v): number for number, v in enumerate(value)} for value in self.values.values()]

    def start(self, given: Mapping[str, Fact]) -> State:
        """Return the state at the start of a run.

        Args:
            given: values by fact; all other facts have the first of their values.
        """
        return self.changed((0,) * len(self.values), self.change(given))

    def condition(self, given: Mapping[str, object]) -> Condition:
        """Return conditions as numbers of facts, each with the indices of its allowed values.

        Args:
            given: allowed value, or list of allowed values, by fact; all names and values must be valid.
        """
        listed = ((name, item if isinstance(item, list) else [item]) for name, item in given.items())
        return tuple((self.number[name], self._numbers(name, item)) for name, item in listed)

    def change(self, given: Mapping[str, Fact]) -> Change:
        """Return changes of facts in compact form: the number of each changed fact, and the index of its new
        value.

        Args:
            given: new value by fact; all names and values must be valid.
        """
        return tuple((self.number[name], self._numbered(name, value)) for name, value in given.items())

    def changed(self, state: State, change: Change) -> State:
        """Return the state after a change of some facts; all others keep their values."""
        values = list(state)
        for fact, value in change:
            values[fact] = value
        return tuple(values)

    def facts_of(self, state: State) -> dict[str, Fact]:
        """Return the physical facts of a state, without those about the robot's knowledge, by name."""
        return {
            name: values[number] for (name, values), number in zip(self.facts.items(), state, strict=False)
        }

    def name_of(self, state: State) -> str:
        """Return the name of a state's situation, which lists values of facts.

        The listed facts are all physical facts, and those facts about the robot's knowledge that do not have
        the first of their possible values.
        """
        stated = (
            (name, values[number])
            for (name, values), number in zip(self.values.items(), state, strict=True)
            if name in self.facts or number
        )
        return ", ".join(self._words(name, value) for name, value in stated)

    def words(self, conditions: Mapping[str, object]) -> str:
        """Return conditions (values by the facts' names) as text with commas, like a situation's name."""
        return ", ".join(self._words(name, value) for name, value in conditions.items())

    def _words(self, name: str, value: object) -> str:
        """Return a value in words: alone if it is that of no other fact, otherwise with the fact's name."""
        is_unique = isinstance(value, str) and (name, value) in self._unique
        return str(value) if is_unique else f"{name} {value_in_words(value)}"

    @cached_property
    def _unique(self) -> set[tuple[str, object]]:
        """Words that are a value of one physical fact only."""
        texts = [(name, value) for name, values in self.values.items() for value in values]
        counts = Counter(value_in_words(item) for _, item in texts)
        return {
            (name, item)
            for name, item in texts
            if name in self.facts and isinstance(item, str) and counts[item] == 1
        }

    def _numbers(self, name: str, values: Sequence[object]) -> frozenset[int]:
        return frozenset(self._numbered(name, value) for value in values)

    def _numbered(self, name: str, value: object) -> int:
        return self._index[self.number[name]][_key(value)]

    # What is wrong, by keys in the file

    def faults(self) -> Faults:
        """Yield faults in the names and values of a task file's facts, such as a value listed twice."""
        for key, names in (("facts", self.facts), ("known", self.known)):
            for name, values in names.items():
                if name in RESERVED_NAMES:
                    yield (key, name), f"{name!r} is a key of an entry of `then`; allowed: another name"
                seen: set[object] = set()
                for number, value in enumerate(values):
                    if value_in_words(value) in seen:
                        yield (key, name, number), f"{value_in_words(value)} is listed twice; allowed: once"
                    seen.add(value_in_words(value))
        for name in self.known:
            if name in self.facts:
                yield ("known", name), f"{name!r} is one of `facts`; allowed: another name"

    def given_faults(self, path: KeyPath, given: Mapping[str, object], only_known: bool = False) -> Faults:
        """Yield a fault for each unknown name or value of a fact in the conditions or changes of an action.

        Args:
            path: path of keys in the file that leads to the conditions or changes.
            given: values, or lists of values, by the fact's name.
            only_known: True if physical facts are faults as well, as in changes by a Fail.
        """
        allowed = self.known if only_known else self.values
        for name, value in given.items():
            if only_known and name in self.facts:
                wrong = f"{name!r} is a physical fact, and a Fail changes none"
                yield (
                    (*path, name),
                    f"{wrong}; allowed: {listed(self.known) or 'names in `known`'}",
                )
            elif name not in allowed:
                yield (*path, name), f"unknown fact {name!r}{suggest(name, allowed)}"
            else:
                yield from self._value_faults((*path, name), name, value)

    def _value_faults(self, path: KeyPath, name: str, value: object) -> Faults:
        each = list(enumerate(value)) if isinstance(value, list) else [(None, value)]
        for number, one in each:
            if _key(one) not in self._index[self.number[name]]:
                said = suggest(value_in_words(one), list(map(value_in_words, self.values[name])))
                at = path if number is None else (*path, number)
                yield at, f"{name} is never {value_in_words(one)!r}{said}"

    def entry_faults(self, entry: ConditionEntry) -> Faults:
        """Yield a fault for each unknown fact or value that an action's entry in the task's file contains.

        The fault's place is the path of keys from the action's entry to the value.
        """
        yield from self.given_faults(("if",), entry.condition)
        for number, ending in enumerate(entry.endings):
            yield from self.given_faults(("then",) if entry.is_plain else ("then", number), ending.changes)
        for cause, fail in entry.fails.items():
            yield from self.given_faults(("on_fail", cause, "known"), fail.known, only_known=True)


def _key(value: object) -> object:
    """Return a key for a value, in which True and 1 differ."""
    return type(value) is bool, value
