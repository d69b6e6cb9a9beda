"""Readings and commands as plain data and back, to the last bit: NaN and infinities are allowed."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterable
from enum import Enum
from functools import cache
from typing import Any, Literal, Union

import numpy as np

from handcart.backends.capabilities.capability import Capability


class NotRecordable(TypeError):
    """Error for a capability that returns values of a type that cannot be recorded."""


def plain(value: Any) -> Any:
    """Convert a reading, or an argument of a command, to numbers, texts, arrays and lists, which
    `saved_state.pack` accepts.
    """
    if isinstance(value, Enum):
        return value.value
    if value is None or isinstance(value, np.ndarray | bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if dataclasses.is_dataclass(value):
        return [plain(getattr(value, field.name)) for field in dataclasses.fields(value)]
    raise NotRecordable(f"values of the type {type(value).__name__} cannot be recorded")


def typed(data: Any, kind: Any) -> Any:
    """Convert plain data of a recording back to a value of its original type; raise `TypeError` for wrong
    data.

    Args:
        data: result of `plain`.
        kind: type of the original value, as annotated.
    """
    origin, args = typing.get_origin(kind) or kind, typing.get_args(kind)
    if origin in (Union, types.UnionType):
        others = [arg for arg in args if arg is not types.NoneType]
        return None if data is None else typed(data, others[0])
    if kind in (None, types.NoneType) or origin is Literal or origin is Any:
        return data
    if origin is float:
        return float(data)
    if _is_array(kind) or origin in (bool, int, str):
        return data
    fields = _fields(origin)
    if not isinstance(data, list) or len(data) != len(fields):
        raise TypeError(f"no {origin.__name__}")
    return origin(*(typed(item, field) for item, field in zip(data, fields, strict=True)))


def _is_array(kind: Any) -> bool:
    """Return whether a type is an array; numpy's `NDArray` is an alias (PEP 695) from 2.5 on."""
    origin = typing.get_origin(kind) or kind
    value = getattr(origin, "__value__", origin)
    return (typing.get_origin(value) or value) is np.ndarray


@cache
def _fields(kind: Any) -> tuple[Any, ...]:
    """Return the types of the fields of a named tuple or dataclass."""
    names: Iterable[str]
    if dataclasses.is_dataclass(kind):
        names = [field.name for field in dataclasses.fields(kind)]
    elif issubclass(kind, tuple) and hasattr(kind, "_fields"):
        names = kind._fields
    else:
        raise NotRecordable(f"values of the type {kind.__name__} cannot be replayed")
    hints = typing.get_type_hints(kind)
    return tuple(hints[name] for name in names)


@cache
def result_type(kind: type[Capability], method: str) -> Any:
    """Return the declared type of the result of a method or property of a capability."""
    found = getattr(kind, method)
    return typing.get_type_hints(found.fget if isinstance(found, property) else found)["return"]
