"""Checking the parameters that a task file gives to a primitive."""

from __future__ import annotations

import types
import typing
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from pydantic import TypeAdapter, create_model
from pydantic.fields import FieldInfo

from handcart.files.errors import FileError
from handcart.files.findings import Findings
from handcart.files.models.loading import load_part
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import Node
from handcart.networks.graph.network import Binding
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.place_name import Names
from handcart.primitives.knowledge.world_model import UnknownFact, WorldModel

from .parameters import reference, with_element
from .repetition import Element


class ParameterReader:
    """Reader of the parameters of a task file's actions, which the file has under the key `with`."""

    def __init__(
        self, document: Document, findings: Findings, known: Mapping[str, Collection[object]]
    ) -> None:
        """Create a reader for all actions of a task file.

        Args:
            document: the task file.
            findings: findings are added here.
            known: known names of each entry that parameters are marked with (`Names`), such as `places`; an
                entry without a file is missing.
        """
        self._document = document
        self._findings = findings
        self._known = known

    def binding(self, kind: type[ActionPrimitive], number: int, element: Element | None) -> Binding | None:
        """Return the binding of an action, its primitive with the parameters; None if the parameters are
        invalid.

        Args:
            kind: the class of the primitive.
            number: number of the action in the file.
            element: element of a repeat; None: the action is outside the repeated parts.
        """
        before = len(self._findings)
        given = self._given(number, element)
        late = self._late(kind, given)
        self._check_names(kind, given)
        fixed = self._fixed(kind, number, given, late)
        return Binding(kind, fixed, late) if len(self._findings) == before else None

    def _given(self, number: int, element: Element | None) -> Node:
        action, _ = self._document.root.deepest(("actions", number))
        written = action.child("with") or replace(action, content={})
        return with_element(written, element, self._document.root, self._findings)

    def _late(self, kind: type[ActionPrimitive], given: Node) -> dict[str, str]:
        content = given.content if isinstance(given.content, dict) else {}
        late: dict[str, str] = {}
        for name, node in content.items():
            key = reference(node, "model")
            if key is not None and name in kind.model_fields:
                late[name] = key
                self._check_type(kind.model_fields[name], name, key, node)
        return late

    def _check_type(self, field: FieldInfo, name: str, key: str, node: Node) -> None:
        try:
            given = WorldModel.type_of(key)
        except UnknownFact as unknown:
            self._add(node, str(unknown))
            return
        if not _fits(given, field.annotation):
            wrong = f"{name}: {key} is of type {_called(given)}; allowed: {_called(field.annotation)}"
            self._add(node, wrong)

    def _fixed(
        self, kind: type[ActionPrimitive], number: int, given: Node, late: dict[str, str]
    ) -> dict[str, Any]:
        content = given.content if isinstance(given.content, dict) else {}
        # A reference to nothing is already reported.
        open_ = {*late, *(key for key, part in content.items() if _is_reference(part))}
        kept = replace(given, content={key: part for key, part in content.items() if key not in open_})
        path = ("actions", number, "with")
        document = self._document.with_value(path, kept)
        try:
            value = load_part(document, path, _adapter(kind, frozenset(open_ & kind.model_fields.keys())))
        except FileError as error:
            self._findings.take(error)
            return {}
        return {name: getattr(value, name) for name in kind.model_fields if name not in open_}

    def _check_names(self, kind: type[ActionPrimitive], given: Node) -> None:
        for name, field in kind.model_fields.items():
            node, entry = given.child(name), named_entry(field)
            if node is None or entry not in self._known or not isinstance(node.content, str | int):
                continue
            known = self._known[entry]
            if isinstance(node.content, int) and all(isinstance(one, str) for one in known):
                continue  # its type is wrong: that is reported
            if node.content not in known:
                allowed = suggest(str(node.content), [str(item) for item in known])
                self._add(node, f"{name}: unknown {entry[:-1]} {node.content!r}{allowed}")

    def _add(self, node: Node, message: str) -> None:
        where = Document(node.file, b"", node)
        self._findings.add(where.finding((), message))


def _is_reference(node: Node) -> bool:
    return any(reference(node, kind) is not None for kind in ("parameter", "each"))


@cache
def _adapter(kind: type[ActionPrimitive], late: frozenset[str]) -> TypeAdapter[Any]:
    """Return the primitive as a type in which parameters that are bound late may be missing."""
    if not late:
        return TypeAdapter(kind)
    missing: dict[str, Any] = dict.fromkeys(sorted(late), (Any, None))
    return TypeAdapter(create_model(kind.__name__, __base__=kind, __module__=kind.__module__, **missing))


def named_entry(field: FieldInfo) -> str:
    """Return the entry of the world model, such as `places`, that has to contain a parameter's value.

    The parameter's annotation in the primitive names this entry (`Names`). The result is empty if it names
    none.
    """
    marks = [mark for part in (field, *_options(field)) for mark in getattr(part, "metadata", ())]
    marks += [mark for part in _options(field) for mark in getattr(part, "__metadata__", ())]
    return next((mark.entry for mark in marks if isinstance(mark, Names)), "")


def _options(field: FieldInfo) -> tuple[Any, ...]:
    """Return the alternatives of an optional parameter, such as `PlaceName` of `PlaceName | None`."""
    return typing.get_args(field.annotation)


def _fits(given: Any, wanted: Any) -> bool:
    is_union = typing.get_origin(wanted) in (typing.Union, types.UnionType)
    options = typing.get_args(wanted) if is_union else (wanted,)
    return given in options or Any in options or (given is int and float in options)


def _called(kind: Any) -> str:
    return getattr(kind, "__name__", None) or str(kind)
