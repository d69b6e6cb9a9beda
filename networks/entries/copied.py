"""Situations and actions of a future network, each with its origin in the task's file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from handcart.files.yaml.yaml_node import KeyPath


@dataclass(frozen=True)
class Element:
    """One of the values for which a `repeat` in a task file copies a part of the network."""

    number: int
    """Number of the element in its part, from 0."""
    path: KeyPath
    """Position in the task's document."""
    name: str
    """Name by which `{each: NAME}` refers to the element."""
    value: Any
    words: str
    """Unique name shown to people, `place[2] (kitchen)`; nested elements begin with the one around them."""
    around: Element | None = None
    """Element of the surrounding part; None for an element of an outermost part."""

    def chain(self) -> list[Element]:
        """Return this element of a list over which the task repeats actions, after the elements of
        surrounding lists.

        The outermost list's element comes first.
        """
        return [*(self.around.chain() if self.around else ()), self]


@dataclass(frozen=True)
class Copied:
    """Action of a network, which is a copy of an action in the task's file, or a skip.

    A skip leaves one element of a list undone for which a part of the network is repeated.
    """

    source: str
    target: str
    on_fail: str | None
    entry: int | None
    """Number of the action in the file; None: a skip."""
    element: Element | None = None
    """Element that the copy belongs to; None: it is outside the repeated parts."""
    others: tuple[str, ...] = ()
    """Further situations that Success may lead to."""
    fails: tuple[str | None, ...] = ()
    """Situations that Fails of named causes lead to; None: it remains as it is."""


@dataclass(frozen=True)
class Copies:
    """Situations and actions of the network that is built from a task file; those in a `repeat` (a part of
    the task that is done for each element of a list) have a copy for each element.
    """

    situations: Mapping[str, tuple[str, Element | None]]
    """Name in the file, and element, of each situation by its name in the network."""
    actions: tuple[Copied, ...]
    start: str
