"""`{parameter: KEY}`, `{each: NAME}`, `{all: places}` in a task file: put in before anything else is read."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath, Node

from .repetition import Element, UnknownElement, found_in

PARAMETERS_KEY = "parameters"
REPEAT_KEY = "repeat"
MAX_VALUES = 50_000
"""Maximum number of values that substitution adds: two lists of references can expand to millions."""
MAX_DEPTH = 32
"""Maximum depth of lists and mappings, and of parameters that refer to each other."""


def with_parameters(document: Document, findings: Findings) -> Document:
    """Return the document with each reference to a parameter replaced by the parameter's value.

    Unknown parameters, and those that refer to themselves, are added to `findings`.

    Raises:
        FileError: the document becomes too large by the replacement.
    """
    root = document.root
    if not isinstance(root.content, dict):
        return document
    section = root.content.get(PARAMETERS_KEY)
    given = section.content if section and isinstance(section.content, dict) else {}
    values = ParameterValues(given, findings)
    whole = replace(root, content={key: part for key, part in root.content.items() if key != PARAMETERS_KEY})
    put_in = values.put_in(whole).content
    assert isinstance(put_in, dict)
    parts = dict(put_in)
    if section is not None:
        parts[PARAMETERS_KEY] = section
    return replace(document, root=replace(root, content=parts))


def with_listed_repeats(document: Document) -> Document:
    """Return the document with its key `repeat` as a list, even if the file has a single mapping there."""
    node = document.root.child(REPEAT_KEY)
    if node is None or not isinstance(node.content, dict):
        return document
    return document.with_value((REPEAT_KEY,), replace(node, content=[node]))


def with_all(document: Document, entry: str, names: Collection[object]) -> Document:
    """Return a task's document in which `names` replace `{all: ENTRY}` as the list to repeat actions over.

    ENTRY is an entry of the world model, such as `places`; only references to `entry` are replaced.
    """
    for over in _overs(document):
        node, there = document.root.deepest(over)
        if there and reference(node, "all") == entry:
            listed = [replace(node, content=name) for name in names if isinstance(name, str | int)]
            document = document.with_value(over, replace(node, content=listed))
    return document


def goes_over_unknown(document: Document) -> bool:
    """Return whether a task repeats actions over a list `{all: ENTRY}` that was not yet replaced by its
    names.
    """
    return any(reference(document.root.deepest(over)[0], "all") is not None for over in _overs(document))


def repeat_count(document: Document) -> int:
    """Return the number of lists over which a task repeats actions (key `repeat`), valid or not."""
    repeats = document.root.child(REPEAT_KEY)
    return len(repeats.content) if repeats and isinstance(repeats.content, list) else 0


def _overs(document: Document) -> list[KeyPath]:
    """Return the paths of the lists that the document's repeats go over."""
    return [(REPEAT_KEY, number, "over") for number in range(repeat_count(document))]


def with_element(node: Node, element: Element | None, root: Node, findings: Findings) -> Node:
    """Return a node of the task's file, in which each `{each: NAME}` or `{each: NAME.KEY}` is replaced by the
    present element of the list over which the task repeats actions.

    Args:
        node: a node of the document at `root`.
        element: the element; None: the node is outside the repeated parts.
        root: root of the document that contains the elements.
        findings: findings are added here.
    """
    each = reference(node, "each")
    if each is not None:
        try:
            found, _ = root.deepest(found_in(each, element)[0])
        except UnknownElement as unknown:
            findings.add(_at(node, str(unknown)))
            return node
        return replace(found, key_line=node.key_line, key_column=node.key_column)
    if isinstance(node.content, dict):
        parts = {key: with_element(part, element, root, findings) for key, part in node.content.items()}
        return replace(node, content=parts)
    if isinstance(node.content, list):
        return replace(node, content=[with_element(part, element, root, findings) for part in node.content])
    return node


@dataclass(frozen=True)
class _Value:
    node: Node
    size: int
    """Number of values in the node, itself included."""
    depth: int
    written: int = 1
    """Number of values in the node as it is written, before substitution."""


class ParameterValues:
    """Substitution of named parameters by the parameters' values; a parameter may refer to another one."""

    def __init__(self, declared: Mapping[str, Node], findings: Findings) -> None:
        """Read the section `parameters`; findings are added to `findings`."""
        self._declared = declared
        self._findings = findings
        self._under_way: list[str] = []
        self._known: dict[str, _Value] = {}
        for name in declared:
            self._value_of(name)

    def put_in(self, node: Node) -> Node:
        """Return a copy of the node with each reference to a parameter replaced by the parameter's value.

        Raises:
            FileError: the node becomes too large.
        """
        return self._put_in(node).node

    def _value_of(self, name: str) -> _Value:
        if name not in self._known:
            self._under_way.append(name)
            self._known[name] = self._put_in(self._declared[name])
            self._under_way.pop()
        return self._known[name]

    def _put_in(self, node: Node) -> _Value:
        name = reference(node, "parameter")
        if name is not None:
            return self._named(name, node)
        if isinstance(node.content, dict):
            parts = {key: self._put_in(part) for key, part in node.content.items()}
            content: Any = {key: part.node for key, part in parts.items()}
            return self._whole(node, content, list(parts.values()))
        if isinstance(node.content, list):
            items = [self._put_in(part) for part in node.content]
            return self._whole(node, [item.node for item in items], items)
        return _Value(node, 1, 0)

    def _named(self, name: str, node: Node) -> _Value:
        wrong = self._why_not(name)
        if wrong:
            self._findings.add(_at(node, wrong))
            return _Value(node, 1, 0)
        known = self._value_of(name)
        placed = replace(known.node, key_line=node.key_line, key_column=node.key_column)
        return replace(known, node=placed, written=1)

    def _why_not(self, name: str) -> str:
        if name not in self._declared:
            return f"unknown parameter {name!r}{suggest(name, self._declared)}"
        if name in self._under_way:
            circle = [*self._under_way[self._under_way.index(name) :], name]
            return (
                f"the parameter {name!r} refers to itself: {', '.join(circle)}; allowed: a value in the end"
            )
        if len(self._under_way) >= MAX_DEPTH:
            return f"more than {MAX_DEPTH} parameters refer to each other; allowed: fewer"
        return ""

    def _whole(self, node: Node, content: Any, parts: list[_Value]) -> _Value:
        size = 1 + sum(part.size for part in parts)
        depth = 1 + max((part.depth for part in parts), default=0)
        written = 1 + sum(part.written for part in parts)
        if size - written > MAX_VALUES:
            wrong = f"with its parameters put in this holds more than {MAX_VALUES} values; allowed: fewer"
            raise FileError([_at(node, wrong)])
        if depth > MAX_DEPTH:
            wrong = f"with its parameters put in this is deeper than {MAX_DEPTH} levels; allowed: flatter"
            raise FileError([_at(node, wrong)])
        return _Value(replace(node, content=content), size, depth, written)


def reference(node: Node, kind: str) -> str | None:
    """Return the name in a task file's node of the form `{kind: NAME}`; None if it has another form."""
    content = node.content
    if not isinstance(content, dict) or list(content) != [kind]:
        return None
    name = content[kind].content
    return name if isinstance(name, str) else None


def _at(node: Node, message: str) -> Finding:
    return Finding(node.file, node.line, node.column, message)
