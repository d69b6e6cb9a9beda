"""`{parameter: KEY}`, `{each: NAME}`, `{all: places}` in a task file: put in before anything else is read."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from handcart.files.errors import Finding
from handcart.files.findings import Findings
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath, Node

from .parameter_values import ParameterValues, reference
from .repetition import Element, UnknownElement, found_in

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


def with_element(node: Node, element: Element | None, root: Node, findings: Findings) -> Node:
    """The node with the element of a repeat wherever `{each: NAME}` or `{each: NAME.KEY}` stands.

    Args:
        node: of the document at `root`.
        element: whose it is; None: it stands outside the repeated parts.
        root: of the document in which the elements stand.
        findings: what is wrong is added here.
    """
    each = reference(node, "each")
    if each is not None:
        try:
            found, _ = root.deepest(found_in(each, element)[0])
        except UnknownElement as unknown:
            findings.add(_unknown(node, str(unknown)))
            return node
        return replace(found, key_line=node.key_line, key_column=node.key_column)
    if isinstance(node.content, dict):
        parts = {key: with_element(part, element, root, findings) for key, part in node.content.items()}
        return replace(node, content=parts)
    if isinstance(node.content, list):
        return replace(node, content=[with_element(part, element, root, findings) for part in node.content])
    return node


def _unknown(node: Node, message: str) -> Finding:
    return Finding(node.file, node.line, node.column, message)
