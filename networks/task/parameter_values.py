"""The values of a task's parameters, put in wherever one is named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_node import Node

LARGEST = 50_000
"""Values in a file with its parameters put in: two lists of references stand for millions."""
DEEPEST = 32
"""Levels of lists and mappings, and parameters that stand for each other."""


@dataclass(frozen=True)
class _Value:
    node: Node
    size: int
    """Values in it, itself included."""
    depth: int


class ParameterValues:
    """Puts values of parameters in; a parameter may stand for another one."""

    def __init__(self, declared: Mapping[str, Node], findings: Findings) -> None:
        """With what stands in the section `parameters`; what is wrong is added to `findings`."""
        self._declared = declared
        self._findings = findings
        self._under_way: list[str] = []
        self._known: dict[str, _Value] = {}
        for name in declared:
            self._value_of(name)

    def put_in(self, node: Node) -> Node:
        """The node with a value wherever it names a parameter; raises `FileError` if it grows too large."""
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
        return replace(known, node=replace(known.node, key_line=node.key_line, key_column=node.key_column))

    def _why_not(self, name: str) -> str:
        if name not in self._declared:
            return f"unknown parameter {name!r}{suggest(name, self._declared)}"
        if name in self._under_way:
            circle = [*self._under_way[self._under_way.index(name) :], name]
            return (
                f"the parameter {name!r} stands for itself: {', '.join(circle)}; allowed: a value in the end"
            )
        if len(self._under_way) >= DEEPEST:
            return f"more than {DEEPEST} parameters stand for each other; allowed: fewer"
        return ""

    def _whole(self, node: Node, content: Any, parts: list[_Value]) -> _Value:
        size = 1 + sum(part.size for part in parts)
        depth = 1 + max((part.depth for part in parts), default=0)
        if size > LARGEST:
            wrong = f"with its parameters put in this holds more than {LARGEST} values; allowed: fewer"
            raise FileError([_at(node, wrong)])
        if depth > DEEPEST:
            wrong = f"with its parameters put in this is deeper than {DEEPEST} levels; allowed: flatter"
            raise FileError([_at(node, wrong)])
        return _Value(replace(node, content=content), size, depth)


def reference(node: Node, kind: str) -> str | None:
    """What `{kind: NAME}` names; None if the node is something else."""
    content = node.content
    if not isinstance(content, dict) or list(content) != [kind]:
        return None
    name = content[kind].content
    return name if isinstance(name, str) else None


def _at(node: Node, message: str) -> Finding:
    return Finding(node.file, node.line, node.column, message)
