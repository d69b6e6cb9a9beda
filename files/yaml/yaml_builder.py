"""Builder of a tree from the events of a YAML parser, which refuses features useless in a task file.

It works on events, one after the other, so that nothing is ever expanded, constructed or recursed into:
the cost is bounded by the allowed number of values, whatever the file.
"""

import re
from typing import Any

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.printable import clipped, composed
from handcart.files.yaml.scalars import Scalar, UnclearScalar, resolve_plain
from handcart.files.yaml.yaml_node import Node

MAX_DEPTH = 32
_NODES = ("AliasEvent", "ScalarEvent", "SequenceStartEvent", "MappingStartEvent")
_MAX_FINDINGS = 50
_HALVES = re.compile("[\ud800-\udfff]")


class TreeBuilder:
    """Builder of a file's tree from the parser's events; `root` is the tree after the last event.

    `take` raises `FileError` at a fault after which it cannot continue: values nested too deeply, too many
    values, or a second document. All other faults are collected in `findings`.
    """

    def __init__(self, file: str, max_nodes: int) -> None:
        self.file = file
        self.findings = Findings()
        self.root: Node | None = None
        self.latest: Any = None  # mark of the latest event, for errors that have none
        self._max_nodes = max_nodes
        self._nodes = 0
        self._documents = 0
        self._open: list[_Open] = []

    def take(self, event: Any) -> None:
        """Add the next event of PyYAML or ruamel.yaml to the tree; the events of both have the same names and
        fields.
        """
        self.latest = event.start_mark
        kind = type(event).__name__
        if kind in _NODES:
            self._count(event)
            if kind == "AliasEvent" or event.anchor is not None or getattr(event, "tag", None) is not None:
                self._refuse_extras(event)
        match kind:
            case "ScalarEvent":
                self._scalar(event)
            case "MappingStartEvent":
                self._begin(event, {})
            case "SequenceStartEvent":
                self._begin(event, [])
            case "AliasEvent":
                self._add(event, None)
            case "MappingEndEvent" | "SequenceEndEvent":
                self._open.pop()
            case "DocumentStartEvent":
                self._document(event)

    def tree(self) -> Node:
        """Return the tree after all events; raises `FileError` with all faults that were found."""
        self.findings.raise_all()
        if self.root is None or self.root.content is None:
            raise FileError([Finding(self.file, 1, 1, "the file is empty; allowed: keys with values")])
        return self.root

    def take_findings(self) -> tuple[Finding, ...]:
        """Return the faults that were found, and forget them, so that `tree` returns the tree."""
        try:
            self.findings.raise_all()
        except FileError as error:
            self.findings = Findings()
            return error.findings
        return ()

    def problem(self, mark: Any, message: str) -> None:
        """Collect a finding at a mark of the parser, which counts lines and columns from 0.

        Raises:
            FileError: there are too many findings; with all of them.
        """
        self.findings.add(Finding(self.file, mark.line + 1, mark.column + 1, message))
        if len(self.findings) >= _MAX_FINDINGS:
            self.findings.raise_all()

    def _stop(self, event: Any, message: str) -> None:
        self.problem(event.start_mark, message)
        self.findings.raise_all()

    def _count(self, event: Any) -> None:
        self._nodes += 1
        if self._nodes > self._max_nodes:
            self._stop(event, f"more than {self._max_nodes} values; allowed: at most {self._max_nodes}")

    def _refuse_extras(self, event: Any) -> None:
        if type(event).__name__ == "AliasEvent":
            self.problem(event.start_mark, f"the alias *{clipped(event.anchor)}; allowed: the value itself")
            return
        if event.anchor is not None:
            self.problem(
                event.start_mark, f"the anchor &{clipped(event.anchor)}; allowed: values without one"
            )
        tag = getattr(event, "tag", None)
        if tag is not None:
            self.problem(event.start_mark, f"the tag {clipped(tag)}; allowed: values without one")

    def _document(self, event: Any) -> None:
        self._documents += 1
        if self._documents > 1:
            self._stop(event, "a second document begins; allowed: one in a file")
        if event.version not in (None, (1, 2)):
            number = ".".join(str(part) for part in event.version)
            self._stop(event, f"YAML {number} is asked for; allowed: YAML 1.2")

    def _scalar(self, event: Any) -> None:
        if _HALVES.search(event.value):
            self.problem(event.start_mark, "half a character (a lone surrogate); allowed: whole ones")
        if self._open and self._open[-1].wants_key:
            self._key(event, composed(event.value))
            return
        self._add(event, self._value(event))

    def _value(self, event: Any) -> Scalar:
        text = composed(event.value)
        if not _is_plain(event):
            return text
        try:
            return resolve_plain(text)
        except UnclearScalar as unclear:
            self.problem(event.start_mark, str(unclear))
            return text

    def _key(self, event: Any, text: str) -> None:
        mapping = self._open[-1]
        if _is_plain(event) and text in ("<<", "", "~", "null"):
            what = "the merge key <<" if text == "<<" else "an empty key"
            self.problem(event.start_mark, f"{what}; allowed: keys that are words")
        first = mapping.keys.get(text)
        if first is not None:
            where = f"first on line {first.line + 1}"
            self.problem(event.start_mark, f"the key {clipped(text)!r} is here again, {where}; allowed: once")
        else:
            mapping.keys[text] = event.start_mark
        mapping.key, mapping.key_mark, mapping.wants_key = text, event.start_mark, False

    def _begin(self, event: Any, content: Any) -> None:
        if len(self._open) >= MAX_DEPTH:
            self._stop(event, f"nested deeper than {MAX_DEPTH} levels; allowed: at most {MAX_DEPTH}")
        self._add(event, content)
        self._open.append(_Open(content))

    def _add(self, event: Any, content: Any) -> None:
        mark = event.start_mark
        parent = self._open[-1] if self._open else None
        if parent is not None and parent.wants_key:
            self.problem(mark, "a key that isn't a word; allowed: keys that are words")
            parent.key, parent.key_mark, parent.wants_key = "", mark, False
            return
        key_mark = parent.key_mark if parent is not None and parent.key_mark is not None else mark
        place = (mark.line + 1, mark.column + 1, key_mark.line + 1, key_mark.column + 1)
        node = Node(content, self.file, *place)
        if parent is None:
            self.root = node
        elif isinstance(parent.content, list):
            parent.content.append(node)
        else:
            parent.content.setdefault(parent.key, node)
            parent.wants_key = True


class _Open:
    """List or mapping whose end has not been reached yet."""

    __slots__ = ("content", "key", "key_mark", "keys", "wants_key")

    def __init__(self, content: list[Node] | dict[str, Node]) -> None:
        self.content = content
        self.keys: dict[str, Any] = {}
        self.key = ""
        self.key_mark: Any = None
        self.wants_key = isinstance(content, dict)


def _is_plain(event: Any) -> bool:
    return event.style in (None, "")
