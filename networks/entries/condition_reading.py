"""Reading of `facts`, `known`, `start`, `goal` and `otherwise` of a task, and of the network they span."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from handcart.files.errors import FileError
from handcart.files.findings import Findings
from handcart.files.models.loading import load_part
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.graph.network import Fact

from .aims_entry import ConditionInterrupt
from .condition_entry import ConditionEntry, Conditions, Values
from .fact_space import FactSpace
from .generating import Generated, NetworkGenerator, NotGenerated

FACTS_KEY = "facts"
"""Key of a task whose network is generated."""
Fault = tuple[KeyPath, str]


def has_conditions(document: Document) -> bool:
    """Return whether a task's file states facts and conditions, from which its network is generated."""
    return document.root.child(FACTS_KEY) is not None


class ConditionReader:
    """Reader of the conditions in a task file, from which the task's network is generated.

    It ignores values of a wrong type, because the validation of the complete file reports these.
    """

    def __init__(self, document: Document) -> None:
        """Read the facts, their values at the start, and the conditions of goals and interrupts."""
        self._document = document
        self._space = FactSpace(self._values("facts"), self._values("known"))
        self._start: Mapping[str, Fact] = self._part("start", dict[str, Fact]) or {}
        goal = self._part("goal", Conditions | list[Conditions]) or []
        self._has_goals = isinstance(goal, list)
        self._goals: list[Conditions] = goal if isinstance(goal, list) else [goal]
        interrupts = self._part("interrupts", list[ConditionInterrupt]) or []
        self._interrupts: list[Conditions] = [interrupt.goal for interrupt in interrupts]
        otherwise = self._part("otherwise", Conditions | list[Conditions]) or []
        self._is_listed = isinstance(otherwise, list)
        self._otherwise: list[Conditions] = otherwise if isinstance(otherwise, list) else [otherwise]

    def generated(self, entries: Mapping[int, ConditionEntry], findings: Findings) -> Generated | None:
        """Return the network generated from the conditions and effects of the file's actions.

        Args:
            entries: actions of the file, by number.
            findings: list to which the faults of the conditions are added.

        Returns:
            The network; None if there are faults, or the goal cannot be read.
        """
        before = len(findings)
        for path, fault in self._faults(entries):
            findings.add(self._document.finding(path, fault))
        if len(findings) > before or not self._goals:
            return None
        try:
            generator = NetworkGenerator(self._space, entries, self._goals)
            return generator.generated(self._start, self._otherwise, self._interrupts)
        except NotGenerated as wrong:
            findings.add(self._document.finding((wrong.key,), str(wrong)))
            return None

    def _faults(self, entries: Mapping[int, ConditionEntry]) -> Iterator[Fault]:
        space = self._space
        yield from space.faults()
        yield from space.given_faults(("start",), self._start)
        for number, conditions in enumerate(self._goals):
            goal: KeyPath = ("goal", number) if self._has_goals else ("goal",)
            yield from space.given_faults(goal, conditions)
        for number, interrupt in enumerate(self._interrupts):
            yield from space.given_faults(("interrupts", number, "goal"), interrupt)
        for number, conditions in enumerate(self._otherwise):
            path: KeyPath = ("otherwise", number) if self._is_listed else ("otherwise",)
            yield from space.given_faults(path, conditions)
        for number, entry in entries.items():
            for below, fault in space.entry_faults(entry):
                yield ("actions", number, *below), fault

    def _values(self, key: str) -> Mapping[str, list[Fact]]:
        return self._part(key, dict[str, Values]) or {}

    def _part(self, key: str, kind: Any) -> Any:
        try:
            return load_part(self._document, (key,), kind)
        except FileError:
            return None
