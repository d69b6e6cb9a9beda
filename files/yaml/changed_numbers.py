"""Numbers that stand for those in files, while a context lasts: for who varies them, trial by trial."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from pathlib import Path

from .yaml_node import KeyPath, Node

Changes = Mapping[Path, Mapping[KeyPath, float]]
"""By a file's absolute path: values by where they stand."""
_NONE: Changes = {}
_CHANGES: ContextVar[Changes] = ContextVar("changes", default=_NONE)


@contextmanager
def changed_numbers(changes: Changes) -> Iterator[None]:
    """Whoever reads one of these files meanwhile finds these numbers in it."""
    token = _CHANGES.set(changes)
    try:
        yield
    finally:
        _CHANGES.reset(token)


def with_changes(path: Path, root: Node) -> Node:
    """The tree of a file with the numbers that stand for its own; raises KeyError where one isn't there."""
    if not (changes := _CHANGES.get()):
        return root
    for key, value in changes.get(path.resolve(), {}).items():
        old, there = root.deepest(key)
        if not there:
            raise KeyError(key)
        root = root.replaced(key, replace(old, content=value))
    return root
