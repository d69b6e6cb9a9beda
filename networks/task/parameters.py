"""`{parameter: KEY}`, `{each: NAME}`, `{all: places}` in a task file: put in before anything else is read."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from handcart.files.errors import Finding
from handcart.files.findings import Findings
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath, Node

from .parameter_values import ParameterValues, reference

SECTION = "parameters"
REPEAT = "repeat"


def with_parameters(document: Document, findings: Findings) -> Document:
    """The document with the value of each parameter wherever one is named.

    Unknown ones, and those that stand for themselves, are findings. Raises `FileError` where values put
    in values make too much of it.
    """
    root = document.root
    if not isinstance(root.content, dict):
        return document
    section = root.content.get(SECTION)
    given = section.content if section and isinstance(section.content, dict) else {}
    values = ParameterValues(given, findings)
    whole = replace(root, content={key: part for key, part in root.content.items() if key != SECTION})
    put_in = values.put_in(whole).content
    assert isinstance(put_in, dict)
    parts = dict(put_in)
    if section is not None:
        parts[SECTION] = section
    return replace(document, root=replace(root, content=parts))


def with_listed_repeats(document: Document) -> Document:
    """The document with its repeats as a list, also where there is only one."""
    node = document.root.child(REPEAT)
    if node is None or not isinstance(node.content, dict):
        return document
    return document.with_value((REPEAT,), replace(node, content=[node]))


def with_all(document: Document, entry: str, names: Collection[object]) -> Document:
    """The document with these names where one of its repeats goes over `{all: ENTRY}`."""
    for over in _overs(document):
        node, there = document.root.deepest(over)
        if there and reference(node, "all") == entry:
            listed = [replace(node, content=name) for name in names if isinstance(name, str | int)]
            document = document.with_value(over, replace(node, content=listed))
    return document


def goes_over_unknown(document: Document) -> bool:
    """Whether one of its repeats goes over `{all: ENTRY}` and nothing was put in for that."""
    return any(reference(document.root.deepest(over)[0], "all") is not None for over in _overs(document))


def _overs(document: Document) -> list[KeyPath]:
    """Where its repeats tell what they go over."""
    repeats = document.root.child(REPEAT)
    count = len(repeats.content) if repeats and isinstance(repeats.content, list) else 0
    return [(REPEAT, number, "over") for number in range(count)]


def with_element(node: Node, name: str | None, element: Node | None, findings: Findings) -> Node:
    """The node with the element of a repeat wherever `{each: NAME}` or `{each: NAME.KEY}` stands."""
    path = reference(node, "each")
    if path is not None:
        found = _found(path, name, element)
        if found is not None:
            return replace(found, key_line=node.key_line, key_column=node.key_column)
        allowed = f"; allowed: {name}, {name}.KEY with a key of each element" if name else "; no repeat here"
        findings.add(_unknown(node, f"unknown element {path!r}{allowed}"))
        return node
    if isinstance(node.content, dict):
        parts = {key: with_element(part, name, element, findings) for key, part in node.content.items()}
        return replace(node, content=parts)
    if isinstance(node.content, list):
        return replace(node, content=[with_element(part, name, element, findings) for part in node.content])
    return node


def _found(path: str, name: str | None, element: Node | None) -> Node | None:
    first, *keys = path.split(".")
    if element is None or first != name:
        return None
    found, there = element.deepest(tuple(keys))
    return found if there else None


def _unknown(node: Node, message: str) -> Finding:
    return Finding(node.file, node.line, node.column, message)
