"""Reading of a task file into a checked network: all faults are reported at once, before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar, cast

import networkx as nx

from handcart.backends.backend import Backend
from handcart.backends.capabilities.camera import usable_kinds
from handcart.backends.capabilities.capability import Capability
from handcart.files.errors import FileError
from handcart.files.extras import extra_of, lack
from handcart.files.findings import Findings
from handcart.files.models.loading import load_document, load_part
from handcart.files.models.model import FileModel
from handcart.files.suggest import suggest
from handcart.files.uninstalled import not_installed
from handcart.files.yaml.yaml_document import Document, read_document
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.entries.aims_entry import SituationInterrupt
from handcart.networks.entries.condition_entry import ConditionEntry
from handcart.networks.entries.condition_reading import ConditionReader, has_conditions
from handcart.networks.entries.entry import TaskEntry, listed_names
from handcart.networks.entries.goals_in_order import TooManyGoals
from handcart.networks.graph.ahead import ways_of
from handcart.networks.graph.aims import Aims
from handcart.networks.graph.belief_prior import BeliefPrior
from handcart.networks.graph.network import (
    LOCATE_NAME,
    Action,
    ActionNetwork,
    Binding,
    Fact,
    Situation,
)
from handcart.primitives.clock.wall_clock import ALLOWED_CLOCK, wall_clock_reads
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.registry import primitive_class
from handcart.primitives.restoring.patience import Patience

from .aims_reading import goal_copies, goal_faults, in_order, interrupt_faults, round_faults
from .entry_actions import action_of, chance_faults, entry_faults, limit_faults
from .named_files import file_faults, named_robot, resolved, robot_faults, start_place_faults, with_set
from .parameters import goes_over_unknown, repeat_count, with_all, with_listed_repeats, with_parameters
from .primitive_parameters import ParameterReader
from .repeat_faults import Situations, element_facts, repeat_faults
from .repeating import Copied, Copies, repeated
from .repetition import NotRepeated, repetitions
from .robot_needs import need_findings
from .route_costs import RouteTimes, with_route_costs
from .task_knowledge import PLACES_KIND, TaskKnowledge, read_knowledge
from .task_model import (
    MAX_TASK_BYTES,
    MAX_TASK_NODES,
    ActionEntry,
    AnyTaskFile,
    ConditionFile,
    GivenFact,
    Repeat,
    TaskFile,
)
from .unknown_start import Parts, with_locate
from .unwritten import unwritten

FileModelT = TypeVar("FileModelT", bound=FileModel)
Primitives = Callable[[str], type[ActionPrimitive]]


@dataclass(frozen=True)
class Task:
    """A task file that was read and checked, with its network and the content of the files that it names."""

    file: AnyTaskFile
    document: Document
    network: ActionNetwork
    entries: tuple[int | None, ...]
    """Number in the file of each action of the network; None if it skips an element."""
    knowledge: TaskKnowledge
    """Content of the files that the task names."""

    def path(self, *key: str) -> Path | None:
        """Return the path of the file that the task names under the keys `key`; None if it names none there.

        A name in the file is relative to the task's folder, one set on the command line to the current
        folder.
        """
        return resolved(self.document, key)

    @property
    def robot(self) -> str:
        """A shipped robot's name, or the path of a robot's file."""
        return named_robot(self.document, self.file.robot)

    def check_capabilities(self, backend: Backend, model: WorldModel | None = None) -> None:
        """Check that a robot can do all actions of the task, by the capabilities that its backend has.

        Raise `FileError` with all findings on actions that the robot cannot do.
        """
        self.check_kinds(usable_kinds(backend.capabilities()), model)

    def check_kinds(self, kinds: Sequence[type[Capability]], model: WorldModel | None = None) -> None:
        """Check that a robot can do all actions; raise `FileError` with all that it cannot do.

        Args:
            kinds: classes of the robot's capabilities, such as arm and lidar.
            model: world model at the start, for needs that depend on it; None to check capabilities only.
        """
        findings = Findings()
        findings.add(*need_findings(self.document, self.network, self.entries, kinds, model))
        findings.raise_all()


def load_task(
    path: Path | str, settings: Mapping[str, str] | None = None, primitives: Primitives = primitive_class
) -> Task:
    """Read and check a task file.

    Args:
        path: the file.
        settings: values of `--set KEY=VALUE`, VALUE unparsed; `robot` and `policy` may be set in any task.
        primitives: function that returns a primitive's class by its name, and raises KeyError for an unknown
            name, with the known ones in its message.

    Raises:
        FileError: with every finding.
    """
    document = read_document(path, max_bytes=MAX_TASK_BYTES, max_nodes=MAX_TASK_NODES)
    return _Reader(with_set(document, dict(settings or {})), primitives).task()


class _Reader:
    """Reader of one document that collects its faults."""

    def __init__(self, document: Document, primitives: Primitives) -> None:
        self._findings = Findings()
        self._document = with_listed_repeats(with_parameters(document, self._findings))
        self._primitives = primitives
        self._lacking: set[str] = set()
        self._sound: dict[str, type[ActionPrimitive]] = {}
        self._budgets: Mapping[str, int] = self._silently(("budgets",), dict[str, int]) or {}
        self._knowledge = read_knowledge(self._document, self._findings, resolved)
        self._names = self._knowledge.names()
        self._route_times = RouteTimes(self._document, self._knowledge)
        self._place_names = None if (known := self._knowledge.places) is None else list(known.value.places)
        no_places = None if self._document.root.deepest(("knowledge", PLACES_KIND))[1] else ()
        listed = {**self._names, PLACES_KIND: self._place_names or no_places}
        for kind, names in listed.items():
            if names is not None:  # None: their file is wrong, or missing
                self._document = with_all(self._document, kind, names)
        if goes_over_unknown(self._document):  # otherwise each of its actions would be reported
            self._check_names()
            spans = has_conditions(self._document)
            for number, entry in self._listed("actions", ConditionEntry if spans else ActionEntry).items():
                self._kind(number, entry.do)
            self._findings.raise_all()

    def task(self) -> Task:
        return self._generated() if has_conditions(self._document) else self._written()

    def _generated(self) -> Task:
        """Return the task whose network its conditions span."""
        file, entries = self._whole(ConditionFile), self._listed("actions", ConditionEntry)
        self._check_entries(entries)
        self._check_names()
        found = ConditionReader(self._document).generated(entries, self._findings)
        copies = found.copies if found else Copies({}, (), "")
        actions = self._actions(copies, entries)
        if self._findings or file is None or found is None:
            self._findings.raise_all()
        assert file is not None
        assert found is not None
        aims = file.aims(file.interrupts, lambda number: found.interrupts[number])
        return self._built(file, copies, found.facts, actions, found.goal, found.otherwise, aims)

    def _written(self) -> Task:
        file = self._whole(TaskFile)
        situations, entries = self._situations(), self._listed("actions", ActionEntry)
        # Their facts are only compared, so they may contain values that follow from an element.
        known = {name: Situation(name, cast(Any, facts)) for name, facts in situations.items()}
        self._check_entries(entries, known)
        start = self._named("start", situations)
        goals = self._goals(start, situations)
        interrupts = self._silently(("interrupts",), list[SituationInterrupt]) or []
        self._add_all(interrupt_faults(interrupts, situations))
        self._check_otherwise(situations)
        self._check_names()
        copies = self._copies(situations, entries, start, goals[-1])
        copies, goal = self._in_order(copies, goals)
        facts, faults = element_facts(copies, situations)
        self._add_all(faults)
        actions = self._actions(copies, entries)
        if self._findings or file is None:
            self._findings.raise_all()
        assert file is not None
        wanted = listed_names(file.otherwise)
        otherwise = tuple(copy for text in wanted for copy in goal_copies(copies, text) or (text,))
        aims = file.aims(file.interrupts, lambda number: goal_copies(copies, file.interrupts[number].goal))
        return self._built(file, copies, facts, actions, goal, otherwise, aims)

    # Parts, each None if the file is wrong or lacks it: `_whole` reports that

    def _whole(self, kind: type[FileModelT]) -> FileModelT | None:
        try:
            return load_document(self._document, kind).value
        except FileError as error:
            self._findings.take(error)
            return None

    def _situations(self) -> dict[str, Mapping[str, GivenFact]]:
        found = self._silently(("situations",), dict[str, dict[str, GivenFact] | None])
        return {name: facts or {} for name, facts in (found or {}).items()}

    def _listed(self, key: str, kind: type[FileModelT]) -> dict[int, FileModelT]:
        listed = self._document.root.child(key)
        count = len(listed.content) if listed and isinstance(listed.content, list) else 0
        found = ((number, self._silently((key, number), kind)) for number in range(count))
        return {number: entry for number, entry in found if entry is not None}

    def _silently(self, path: KeyPath, kind: Any) -> Any:
        try:
            return load_part(self._document, path, kind)
        except FileError:
            return None

    def _add(self, path: KeyPath, message: str) -> None:
        self._findings.add(self._document.finding(path, message))

    def _named(self, key: str, situations: Mapping[str, object]) -> str:
        node = self._document.root.child(key)
        name = node.content if node and isinstance(node.content, str) else ""
        if name and situations and name not in situations:
            self._add((key,), f"unknown situation {name!r}{suggest(name, situations)}")
        return name

    def _otherwise(self) -> tuple[str, ...]:
        return listed_names(self._silently(("otherwise",), str | list[str]))

    def _add_all(self, faults: Iterable[tuple[KeyPath, str]]) -> None:
        for path, fault in faults:
            self._add(path, fault)

    def _check_names(self) -> None:
        """Check that the files and the robot that the task names are there."""
        self._add_all([*file_faults(self._document), *robot_faults(self._document)])

    def _goals(self, start: str, situations: Mapping[str, object]) -> tuple[str, ...]:
        """Return the goals in order; at least one, "" if none can be read."""
        given = self._silently(("goal",), str | list[str])
        names = listed_names(given)
        self._add_all(goal_faults(names, isinstance(given, list), start, situations))
        return names or ("",)

    def _in_order(self, copies: Copies, goals: Sequence[str]) -> tuple[Copies, str]:
        if self._findings:  # a goal may be unknown
            return copies, goals[-1]
        try:
            return in_order(copies, goals)
        except TooManyGoals as wrong:
            self._add(("goal",), str(wrong))
            self._findings.raise_all()
            raise

    def _check_otherwise(self, situations: Mapping[str, object]) -> None:
        for name in self._otherwise():
            if situations and name not in situations:
                self._add(("otherwise",), f"unknown situation {name!r}{suggest(name, situations)}")

    def _check_entries(
        self, entries: Mapping[int, TaskEntry], known: Mapping[str, Situation] | None = None
    ) -> None:
        """Check the entries; those of conditions have no known situations."""
        budgets = self._document.root.child("budgets")
        named = list(budgets.content) if budgets and isinstance(budgets.content, dict) else []
        done = {entry.do for entry in entries.values()}
        for number, entry in entries.items():
            faults = limit_faults(entry, named, done)
            if known is not None and isinstance(entry, ActionEntry):
                faults = entry_faults(entry, known, named, done)
            for path, fault in faults:
                self._add(("actions", number, *path), fault)

    def _copies(
        self, situations: Situations, entries: Mapping[int, ActionEntry], start: str, goal: str
    ) -> Copies:
        repeats = self._listed("repeat", Repeat)
        if len(repeats) < repeat_count(self._document):  # every use of its element would be reported too
            self._findings.raise_all()
        ends = {name for repeat in repeats.values() for name in (repeat.start, repeat.goal)}
        parts = repetitions(repeats, entries.values(), set(self._otherwise()) - ends)
        faults = list(repeat_faults(parts, situations, entries, start, goal))
        self._add_all(faults)
        if faults:  # the element of an action is unknown
            self._findings.raise_all()
        try:
            return repeated(situations, entries, start, parts)
        except NotRepeated as wrong:
            self._add((*wrong.part, "over"), str(wrong))
            self._findings.raise_all()
            raise

    def _actions(self, copies: Copies, entries: Mapping[int, TaskEntry]) -> list[Action | None]:
        self._add_all(start_place_faults(self._document, self._place_names))
        reader = ParameterReader(self._document, self._findings, self._names)
        kinds = {number: self._kind(number, entry.do) for number, entry in entries.items()}
        copied = {action.entry for action in copies.actions}
        for number, kind in kinds.items():  # what is wrong with actions that are never possible
            if kind and number not in copied and has_conditions(self._document):
                reader.binding(kind, number, None)
        return [self._action(copied, entries, kinds, reader) for copied in copies.actions]

    def _action(
        self,
        copied: Copied,
        entries: Mapping[int, TaskEntry],
        kinds: Mapping[int, type[ActionPrimitive] | None],
        reader: ParameterReader,
    ) -> Action | None:
        ends = copied.source, copied.target
        if copied.entry is None:
            return Action(*ends, None, attempts=1)
        entry, kind = entries[copied.entry], kinds[copied.entry]
        binding: Binding | None = reader.binding(kind, copied.entry, copied.element) if kind else None
        if binding is None:
            return None
        return action_of(entry, copied, binding, self._budgets)

    def _kind(self, number: int, name: str) -> type[ActionPrimitive] | None:
        if name in self._sound:
            return self._sound[name]
        try:
            kind = self._primitives(name)
            for read in (reads := wall_clock_reads(kind)):
                self._add(("actions", number, "do"), f"{read}; {ALLOWED_CLOCK}")
            return kind if reads else self._sound.setdefault(name, kind)
        except KeyError as unknown:
            self._add(("actions", number, "do"), f"{unknown.args[0]}{not_installed(self._document.file)}")
        except ImportError as missing:
            extra = extra_of(missing)
            wrong = None if extra is None else lack(name, extra)
            if extra is None or wrong is None:  # it is there, and broken
                raise
            if extra not in self._lacking:  # report it once, not for each action
                self._add(("actions", number, "do"), wrong)
            self._lacking.add(extra)
        return None

    def _built(
        self,
        file: AnyTaskFile,
        copies: Copies,
        facts: Mapping[str, Mapping[str, Fact]],
        actions: list[Action | None],
        goal: str,
        otherwise: tuple[str, ...],
        aims: Aims,
    ) -> Task:
        situations = [
            Situation(name, facts[name], element.words if element else None)
            for name, (_, element) in copies.situations.items()
        ]
        every = [action for action in actions if action is not None]
        entries: tuple[int | None, ...] = tuple(copied.entry for copied in copies.actions)
        every = with_route_costs(every, entries, file.actions, facts, self._route_times, self._add)
        parts = Parts(situations, every, copies.start)
        if not self._knowledge.is_start_known:
            parts = with_locate(parts, self._primitives(LOCATE_NAME))
            entries += (None,) * (len(parts.actions) - len(every))
        network = ActionNetwork.build(*parts, goal, otherwise)
        patience = Patience(file.restoring.attempts, file.restoring.wait_s)
        network = replace(network, policy=file.policy, person_s=file.person_s, restoring=patience)
        network = replace(network, aims=aims, belief=BeliefPrior.of(file.belief_attempts, entries))
        self._add_all(round_faults(network))
        if file.policy != "rule":
            self._add_all(chance_faults(file))
        if copies.start == network.goal:
            wrong = f"the start is the goal, {goal!r}: a run would do nothing"
            self._add(("goal",), f"{wrong}; allowed: another situation, or a repeat over its part")
        elif not nx.has_path(ways_of(network), network.start, network.goal):
            self._add(
                ("goal",),
                f"no actions lead from {network.start} to {goal}; allowed: a goal that can be reached",
            )
        if any(action.binding is not None and action.binding.late for action in every):
            self._check_late(file, network, entries)
        self._findings.raise_all()
        return Task(file, self._document, network, entries, self._knowledge)

    def _check_late(self, file: AnyTaskFile, network: ActionNetwork, entries: Sequence[int | None]) -> None:
        given = file.knowledge.model_fields_set if file.knowledge else ()
        for action, name, key in unwritten(network, given):
            wrong = f"{name}: nothing that is done before finds out {key!r}"
            needed = f"needed: before it an action whose primitive writes {key.split('.')[0]!r}"
            number = entries[action.index]
            assert number is not None
            self._add(("actions", number, "with", name), f"{wrong}; {needed}")
