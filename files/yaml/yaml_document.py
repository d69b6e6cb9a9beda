"""A YAML file, read once: its data, the place of each value, its bytes and their checksum.

The language is YAML 1.2 without aliases, anchors, merge keys, tags and second documents, without
duplicate keys, and without words that readers disagree on (files/yaml/scalars.py). Keys are text.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import yaml
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import MAX_LINE, decode_text, read_regular_file
from handcart.files.yaml.yaml_builder import TreeBuilder
from handcart.files.yaml.yaml_node import KeyPath, Node
from handcart.files.yaml.yaml_syntax import syntax_error

MAX_BYTES = 1 << 20
MAX_NODES = 50_000
KEPT_TREES = 32
# libyaml follows YAML 1.1: other line breaks, tabs where 1.2 has none, other words behind these signs.
_READ_DIFFERENTLY = re.compile("[\t\r\x85\u2028\u2029\ufeff&*!%?]")

Changes = Mapping[Path, Mapping[KeyPath, float]]
"""Replacement numbers by key path, by a file's absolute path."""
_NONE: Changes = {}
_CHANGES: ContextVar[Changes] = ContextVar("changes", default=_NONE)
_PASSED: ContextVar[list[Finding] | None] = ContextVar("passed", default=None)


@dataclass(frozen=True)
class Document:
    """Content of a YAML file, with the position of each value."""

    file: str
    content: bytes
    root: Node

    @cached_property
    def sha256(self) -> str:
        """SHA-256 checksum of the bytes of the file, in hexadecimal."""
        return hashlib.sha256(self.content).hexdigest()

    @cached_property
    def data(self) -> Any:
        """Content of the file as dict, list, str, int, float, bool and None, which must not be changed."""
        return self.root.plain()

    @property
    def folder(self) -> Path:
        """The folder that relative paths in the file start from."""
        return Path(self.file).parent

    def position(self, path: KeyPath = ()) -> tuple[int, int]:
        """Return line and column (from 1) of the value at `path`, or of its innermost existing parent."""
        node, _ = self.root.deepest(path)
        return node.line, node.column

    def key_position(self, path: KeyPath) -> tuple[int, int]:
        """Return line and column (from 1) of the key of the value at `path`.

        An item of a list has no key; its own position is returned.
        """
        node, whole = self.root.deepest(path)
        return (node.key_line, node.key_column) if whole else (node.line, node.column)

    def finding(self, path: KeyPath, message: str, *, at_key: bool = False) -> Finding:
        """Return a finding at a value of the file.

        Args:
            path: key path of the value.
            message: "what is wrong; what is allowed".
            at_key: True for the place of the value's key instead.
        """
        node, _ = self.root.deepest(path)
        line, column = self.key_position(path) if at_key else (node.line, node.column)
        return Finding(node.file, line, column, message)

    def is_set(self, path: KeyPath) -> bool:
        """Return whether the value at `path` was set on the command line.

        A relative path set on the command line starts from the current folder, not from the folder of the
        file.
        """
        return self.root.deepest(path)[0].line == 0

    def with_value(self, path: KeyPath, value: Node) -> "Document":
        """Return a copy of the document with another value at `path`.

        Raises:
            KeyError: the mapping or list that should contain the value is missing.
        """
        return replace(self, root=self.root.replaced(path, value))


def read_document(
    path: Path | str,
    *,
    max_bytes: int = MAX_BYTES,
    max_nodes: int = MAX_NODES,
    longest_line: int | None = MAX_LINE,
) -> Document:
    """Read the YAML file `path`; raise `FileError` if it is not readable or not valid YAML.

    The limits are those of `parse_document`, and the largest size of the file in bytes.
    """
    content = read_regular_file(path, max_bytes)
    document = parse_document(content, str(path), max_nodes=max_nodes, longest_line=longest_line)
    return replace(document, root=_with_changes(Path(path), document.root))


@contextmanager
def changed_numbers(changes: Changes) -> Iterator[None]:
    """Replace numbers in all files that are read inside this context.

    A campaign (many trials with random values) changes the numbers of each trial in this way.

    Args:
        changes: new numbers by file and key path; those of an outer context do not apply meanwhile.
    """
    token = _CHANGES.set(changes)
    try:
        yield
    finally:
        _CHANGES.reset(token)


@contextmanager
def reading_past(passed: list[Finding]) -> Iterator[None]:
    """Read past faults of YAML inside this context, to find the faults of the content behind them.

    A duplicate key, an alias, a tag or an unclear scalar is appended to `passed`, and the file is read as if
    it were not there: of duplicate keys the first counts. What is read serves to find faults, for nothing
    else.
    """
    token = _PASSED.set(passed)
    try:
        yield
    finally:
        _PASSED.reset(token)


def _with_changes(path: Path, root: Node) -> Node:
    """Return the tree of a file with its numbers replaced; raise KeyError if one is missing."""
    if not (changes := _CHANGES.get()):
        return root
    for key, value in changes.get(path.resolve(), {}).items():
        old, there = root.deepest(key)
        if not there:
            raise KeyError(key)
        root = root.replaced(key, replace(old, content=value))
    return root


def parse_document(
    content: bytes, file: str, *, max_nodes: int = MAX_NODES, longest_line: int | None = MAX_LINE
) -> Document:
    """Return the document in the bytes of a YAML file.

    Args:
        content: bytes of the file.
        file: name of the file in messages.
        max_nodes: largest allowed number of values.
        longest_line: largest length of a line, in characters; None: any length.

    Raises:
        FileError: the bytes are not valid YAML; the error has a finding for each fault.
    """
    text = decode_text(content, file, longest_line)
    try:
        root = _fast_tree(text, file, max_nodes)  # it is kept, and without a fault
    except FileError:
        if _PASSED.get() is None:
            raise
        root = None
    return Document(file, content, root or _tree(text, file, max_nodes))


@lru_cache(maxsize=KEPT_TREES)
def _fast_tree(text: str, file: str, max_nodes: int) -> Node | None:
    """Return the tree by the fast parser; None if the text needs the exact parser.

    The result is cached, because the trials of a campaign read the same files. A tree is never changed.
    """
    events = fast_events(text)
    builder = TreeBuilder(file, max_nodes)
    try:
        for event in events or ():
            builder.take(event)
    except yaml.YAMLError:
        return None
    return builder.tree() if events is not None else None


def _tree(text: str, file: str, max_nodes: int) -> Node:
    builder = TreeBuilder(file, max_nodes)
    try:
        for event in exact_events(text):
            builder.take(event)
    except FileError:  # is a ValueError too
        raise
    # The parser also lets out what chr(), int() and assert say of absurd escapes and versions.
    except (YAMLError, ValueError, OverflowError, AssertionError) as error:
        builder.findings.take(syntax_error(file, error, builder.latest))
        builder.findings.raise_all()
    passed = _PASSED.get()
    if passed is not None:
        passed += builder.take_findings()
    return builder.tree()


def fast_events(text: str) -> Iterator[Any] | None:
    """Return the parser events of a YAML text from libyaml, thirty times as fast as from `exact_events`.

    The result is None if libyaml is missing, or the text has characters that its YAML 1.1 reads differently.
    """
    if not hasattr(yaml, "CLoader") or _READ_DIFFERENTLY.search(text):
        return None
    return iter(yaml.parse(text, Loader=yaml.CLoader))


def exact_events(text: str) -> Iterator[Any]:
    """Return the parser events of a YAML 1.2 text.

    Iterating over them raises ruamel.yaml.error.YAMLError at the first syntax error.
    """
    return iter(YAML(typ="safe", pure=True).parse(text))
