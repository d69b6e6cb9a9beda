"""Reading of SMACH state machines in YAML, as robots of RoboCup teams and SMACHA scripts have them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from handcart.files.errors import FileError
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import Document, read_document
from handcart.files.yaml.yaml_node import Node

from .lost import Imported, LostConstruct
from .task_draft import FAILED_NAME, GOAL_NAME, TaskDraft, primitive_name

SUCCESS_WORDS = ("succeeded", "success", "successful", "done", "ok", "true", "found", "reached", "finished")
FAIL_WORDS = ("aborted", "failed", "failure", "fail", "error", "false", "timeout", "timed_out", "preempted")
"""Outcomes of SMACH by their meaning; the first one of a state counts as success if none is named so."""
ENDING_WORDS = (*SUCCESS_WORDS, *FAIL_WORDS)
KIND_KEYS = ("template", "type", "class", "state", "state_class", "action", "procedure", "behavior", "skill")
"""Keys that name the action of a state; the first one that it has counts."""
PARAMETER_KEYS = ("params", "parameters", "args", "kwargs", "goal")
INITIAL_KEYS = ("initial_state", "initial", "start", "start_state", "initial_state_label")
CONCURRENT_KINDS = ("concurrence", "concurrent", "parallel")
CONTAINER_KEYS = frozenset({"states", "transitions", "outcomes", *KIND_KEYS, *INITIAL_KEYS})
STATE_KEYS = frozenset({"name", "description", "outcomes", "transitions", *KIND_KEYS, *PARAMETER_KEYS})
SHORT_TRANSITIONS = {
    "next": "succeeded",
    "error": "aborted",
    "on_success": "succeeded",
    "on_failure": "aborted",
}
"""Keys of a state that are transitions of their own, with the outcome that they mean."""
IGNORED_KEYS = frozenset(
    {"name", "description", "title", "comment", "manifest", "node_name", "package", "version"}
)
MAX_SMACH_DEPTH = 20


class _State(NamedTuple):
    """A state of a container."""

    name: str
    """Its name, below those of its containers."""
    node: Node

    @property
    def content(self) -> Mapping[str, Node]:
        return self.node.content if isinstance(self.node.content, dict) else {}


def import_smach(path: Path | str) -> Imported:
    """Convert a SMACH state machine, given as a YAML file, to a task.

    Raises:
        FileError: the file is not a state machine that can be converted.
    """
    document = read_document(path)
    return _SmachReader(document).imported()


class _SmachReader:
    """Reader of one file of SMACH."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._lost: dict[LostConstruct, None] = {}
        self._draft = TaskDraft(Path(document.file).stem)
        self._ends: frozenset[str] = frozenset()

    def imported(self) -> Imported:
        root = _machine(self._document.root)
        if not _states(root):
            wrong = "there are no states; needed: the key `states`, with a mapping or a list"
            raise FileError([self._document.finding((), wrong)])
        self._ends = _outcomes(root)
        name = root.child("name")
        if name is not None and isinstance(name.content, str):
            self._draft.title = name.content
        begin = self._container(root, "", _Exits(), 0)
        return Imported(self._draft.data(begin), tuple(sorted(self._lost)))

    def _container(self, node: Node, prefix: str, exits: Mapping[str, str], depth: int) -> str:
        """Add the states of a container; return the situation in which it begins."""
        states = _states(node)
        self._lose_keys(node, CONTAINER_KEYS, prefix.rstrip("/"))
        begins = {name: self._draft.placeholder() for name, _ in states}
        for name, state in states:
            if name in exits or name in _outcomes(node):
                self._lose(state, f"state {name!r}", "an outcome is called so too; transitions lead here")
        for name, state in states:
            inside = _State(f"{prefix}{name}", state)
            targets = _Exits({**exits, **begins})
            found = self._state(inside, targets, depth, _next(states, name))
            self._draft.bind(begins[name], found)
        first = self._initial(node, [name for name, _ in states])
        return begins[first]

    def _state(self, state: _State, targets: Mapping[str, str], depth: int, following: str | None) -> str:
        """Add a state or a container; return the situation in which it begins."""
        named = self._transitions(state, following)
        for outcome, to in named.items():
            if to not in targets and to.lower() not in ENDING_WORDS and to not in self._ends:
                self._lose(
                    state.node, f"{outcome!r} of {state.name!r}", f"{to!r} is not a state; the task ends"
                )
        transitions = {outcome: targets[to] for outcome, to in named.items()}
        if _states(state.node) and depth < MAX_SMACH_DEPTH:
            kind = self._kind(state).lower()
            if kind in CONCURRENT_KINDS or "outcome_map" in state.content:
                return self._concurrent(state, transitions, depth)
            return self._container(state.node, f"{state.name}/", _Exits(transitions), depth + 1)
        return self._leaf(state, transitions)

    def _concurrent(self, state: _State, transitions: Mapping[str, str], depth: int) -> str:
        """Add the states of a concurrence one after the other."""
        self._lose(state.node, f"concurrence {state.name!r}", "its states are done in order")
        self._lose_keys(state.node, CONTAINER_KEYS, state.name)
        good = next((to for outcome, to in transitions.items() if _is_good(outcome)), GOAL_NAME)
        bad = next((to for outcome, to in transitions.items() if _is_bad(outcome)), FAILED_NAME)
        for name, child in reversed(_states(state.node)):
            inside = _State(f"{state.name}/{name}", child)
            good = self._state(inside, _Both(good, bad), depth + 1, None)
        return good

    def _leaf(self, state: _State, transitions: Mapping[str, str]) -> str:
        here = self._draft.situation(state.name)
        goods = [(outcome, to) for outcome, to in transitions.items() if not _is_bad(outcome)]
        bads = [(outcome, to) for outcome, to in transitions.items() if _is_bad(outcome)]
        goods.sort(key=lambda good: not _is_good(good[0]))
        for outcome, _ in bads[1:]:
            self._lose(state.node, f"outcome {outcome!r} of {state.name!r}", f"it is as {bads[0][0]!r}")
        self._lose_keys(state.node, STATE_KEYS, state.name)
        others = [{"to": to, "result": outcome} for outcome, to in goods[1:]]
        usual = goods[0][1] if goods else FAILED_NAME
        more: dict[str, Any] = {"then": [{"to": usual}, *others]} if others else {}
        self._draft.action(
            primitive_name(self._kind(state)),
            here,
            None if others else usual,
            **more,
            on_fail=bads[0][1] if bads else FAILED_NAME,
            **({"with": given} if (given := self._parameters(state)) else {}),
        )
        return here

    def _transitions(self, state: _State, following: str | None) -> dict[str, str]:
        """Return the names of the states or outcomes after each outcome of a state."""
        found = dict(_pairs(state.content.get("transitions")))
        for key, outcome in SHORT_TRANSITIONS.items():
            short = state.content.get(key)
            if short is not None and isinstance(short.content, str):
                found[outcome] = short.content
        if not found:
            if following is None:
                return {"succeeded": "succeeded", "aborted": "aborted"}
            found["succeeded"] = following
        return found

    def _kind(self, state: _State) -> str:
        for key in KIND_KEYS:
            node = state.content.get(key)
            if node is not None and isinstance(node.content, str):
                return node.content
        return state.name.rpartition("/")[2]

    def _parameters(self, state: _State) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key in PARAMETER_KEYS:
            node = state.content.get(key)
            if node is not None:
                found |= node.plain() if isinstance(node.content, dict) else {key: node.plain()}
        return found

    def _initial(self, node: Node, names: list[str]) -> str:
        for key in INITIAL_KEYS:
            given = _content(node).get(key)
            if given is None:
                continue
            if given.content in names:
                return str(given.content)
            wrong = f"unknown state {str(given.content)!r}{suggest(str(given.content), names)}"
            self._lose(given, f"`{key}`", f"{wrong}; it begins with {names[0]!r}")
        return names[0]

    def _lose_keys(self, node: Node, known: frozenset[str], name: str) -> None:
        """Report the keys of a state or a container that are not read."""
        for key, part in _content(node).items():
            if key not in known | IGNORED_KEYS and key not in SHORT_TRANSITIONS:
                self._lose(part, f"`{key}`{f' of {name!r}' if name else ''}", "it is dropped")

    def _lose(self, node: Node, construct: str, meaning: str) -> None:
        line, column = (node.key_line, node.key_column) if node.key_line else (node.line, node.column)
        self._lost[LostConstruct(line, column, construct, meaning)] = None


class _Exits(dict[str, str]):
    """Situations that follow the outcomes of a container; an outcome that no transition names ends the
    machine.
    """

    def __missing__(self, outcome: str) -> str:
        return FAILED_NAME if _is_bad(outcome) else GOAL_NAME


class _Both(dict[str, str]):
    """Situations that follow the outcomes of a state in a concurrence."""

    def __init__(self, good: str, bad: str) -> None:
        super().__init__()
        self._good, self._bad = good, bad

    def __missing__(self, outcome: str) -> str:
        return self._bad if _is_bad(outcome) else self._good


def _machine(root: Node) -> Node:
    """Return the node of the machine: the root, or the only mapping with states in it."""
    if _states(root) or not isinstance(root.content, dict):
        return root
    inside = [part for part in root.content.values() if _states(part)]
    return inside[0] if len(inside) == 1 else root


def _outcomes(root: Node) -> frozenset[str]:
    """Return the outcomes of the machine."""
    given = root.child("outcomes")
    listed = given.content if given is not None and isinstance(given.content, list) else []
    return frozenset(str(item.content) for item in listed)


def _content(node: Node) -> Mapping[str, Node]:
    return node.content if isinstance(node.content, dict) else {}


def _states(node: Node) -> list[tuple[str, Node]]:
    """Return the states of a container with their names: a mapping, a list of mappings, or named entries."""
    given = _content(node).get("states")
    if given is None:
        return []
    if isinstance(given.content, dict):
        return list(given.content.items())
    if not isinstance(given.content, list):
        return []
    return [pair for item in given.content for pair in _entry(item)]


def _entry(node: Node) -> Iterator[tuple[str, Node]]:
    """Yield the state in an entry of a list: `NAME: {...}`, `{name: NAME, ...}` or `NAME`."""
    if isinstance(node.content, str):
        yield node.content, node
        return
    content = _content(node)
    name = content.get("name") or content.get("label")
    if name is not None and isinstance(name.content, str):
        yield name.content, node
    else:
        yield from content.items()


def _next(states: list[tuple[str, Node]], name: str) -> str | None:
    names = [item for item, _ in states]
    number = names.index(name) + 1
    return names[number] if number < len(names) else None


def _pairs(node: Node | None) -> Iterator[tuple[str, str]]:
    """Yield outcome and target of transitions: a mapping, or a list of mappings or pairs."""
    if node is None:
        return
    if isinstance(node.content, dict):
        for outcome, to in node.content.items():
            if isinstance(to.content, str | int | bool):
                yield outcome, str(to.content)
    elif isinstance(node.content, list):
        for item in node.content:
            pair = item.plain() if isinstance(item.content, list) else None
            if pair is not None and len(pair) == 2:
                yield str(pair[0]), str(pair[1])
            else:
                yield from _listed_pair(item)


def _listed_pair(node: Node) -> Iterator[tuple[str, str]]:
    content = _content(node)
    outcome, to = content.get("outcome") or content.get("on"), content.get("to") or content.get("target")
    if outcome is not None and to is not None:
        yield str(outcome.content), str(to.content)
    else:
        yield from _pairs(node) if content else ()


def _is_bad(outcome: str) -> bool:
    words = outcome.lower().split("_")
    return outcome.lower() in FAIL_WORDS or words[0] in ("not", "no") or any(w in FAIL_WORDS for w in words)


def _is_good(outcome: str) -> bool:
    return not _is_bad(outcome) and any(word in SUCCESS_WORDS for word in outcome.lower().split("_"))
