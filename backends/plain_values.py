"""Convert values of declared types to plain data and back; other types are rejected.

The program declares what can be stored, never the data: numbers, texts, arrays, enumerations, lists,
tuples, sets and mappings, named tuples, dataclasses, models of files, and objects with a `STATE`.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from functools import cache
from typing import Annotated, Any, NamedTuple, Union

import numpy as np
from pydantic import BaseModel

from handcart.robotics.far import MAY_BE_INFINITE

from .saved_state import NotAState

MAX_NUMBER = 1e15
"""Largest absolute value of any finite number in a state, in whichever unit it is."""
MAX_TEXT_LETTERS = 100_000  # characters of a word

Kinds = Mapping[str, Any]
"""Names of attributes, each with the type of its values."""


class _Codec(NamedTuple):
    """Writer and reader for values of one type."""

    write: Callable[[Any], Any]
    read: Callable[[Any], Any]
    """Function that returns the value of plain data; raises ValueError, TypeError or KeyError for invalid
    data.
    """


def attributes(thing: object, kinds: Kinds) -> dict[str, Any]:
    """Return some attributes of an object for a checkpoint, as plain data: numbers, texts, lists and so on.

    Args:
        thing: object whose attributes are returned.
        kinds: names of the attributes, each with the type of its values.

    Returns:
        Plain data by name of the attribute.
    """
    return {name: _codec(kind).write(getattr(thing, name)) for name, kind in kinds.items()}


def set_attributes(thing: object, kinds: Kinds, values: object) -> None:
    """Set an object's attributes from values that `attributes` returned.

    Args:
        thing: object whose attributes are set.
        kinds: names of the attributes, each with the type of its values.
        values: result of `attributes`.

    Raises:
        NotAState: a value is missing, of another type or, if an array, of another shape.
    """
    if not isinstance(values, dict) or values.keys() != kinds.keys():
        raise NotAState(f"no state of a {type(thing).__name__}; needed: {', '.join(kinds) or 'nothing'}")
    for name, kind in kinds.items():
        value = from_plain(values[name], kind, f"{type(thing).__name__}.{name}")
        now = getattr(thing, name)
        if isinstance(now, np.ndarray) and not _same_shape(now, value):
            shape = getattr(value, "shape", None)
            raise NotAState(f"no state of a {type(thing).__name__}: {name} {shape}, needed: {now.shape}")
        setattr(thing, name, value)


def from_plain(data: object, kind: Any, name: str) -> Any:
    """Return the value that `to_plain` converted to plain data.

    Args:
        data: result of `to_plain`.
        kind: type of the value.
        name: name of the value in messages.

    Raises:
        NotAState: the data do not describe a value of this type.
    """
    try:
        return _codec(kind).read(data)
    except (ValueError, TypeError, KeyError, ArithmeticError) as error:
        words = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise NotAState(f"no saved state: {name}: {words}") from None


def to_plain(value: object, kind: Any) -> Any:
    """Convert a value of the type `kind` to plain data for a checkpoint: numbers, texts, lists, arrays and
    mappings.
    """
    return _codec(kind).write(value)


def _same_shape(now: np.ndarray, then: object) -> bool:
    """Return whether an array fits in place of another; an empty one may grow."""
    if not isinstance(then, np.ndarray) or now.ndim != then.ndim:
        return False
    return all(a in (0, b) for a, b in zip(now.shape, then.shape, strict=True))


@cache
def _codec(kind: Any) -> _Codec:
    marks: tuple[Any, ...] = ()
    if typing.get_origin(kind) is Annotated:
        kind, *more = typing.get_args(kind)
        marks = tuple(more)
    kind = _written_out(kind)
    origin, args = typing.get_origin(kind) or kind, typing.get_args(kind)
    if origin in (Union, types.UnionType):
        return _union(args)
    if origin is np.ndarray:
        return _array(np.dtype(typing.get_args(args[1])[0]), marks)
    if origin in (dict, Mapping):
        return _mapping(*map(_codec, args))
    if origin is tuple and args[-1] is not ...:
        return _fixed(tuple, [_codec(arg) for arg in args])
    if origin in (list, tuple, frozenset):
        return _many(origin, _codec(args[0]))
    if origin is float:
        return _Codec(float, _float if MAY_BE_INFINITE not in marks else _any_float)
    if origin in (bool, int, str, bytes, types.NoneType, None):
        return _exactly(types.NoneType if origin is None else origin)
    return _of_class(kind)


def _written_out(kind: Any) -> Any:
    """Resolve a type's alias (PEP 695): numpy's `NDArray` is one from 2.5 on."""
    alias, args = typing.get_origin(kind) or kind, typing.get_args(kind)
    if type(alias).__name__ != "TypeAliasType":
        return kind
    return _written_out(alias.__value__[args] if args else alias.__value__)


@cache
def _of_class(kind: Any) -> _Codec:
    is_class: bool = inspect.isclass(kind)
    if not is_class:
        raise TypeError(f"a checkpoint can't keep values of the type {kind!r}")
    if issubclass(kind, Enum):
        return _Codec(lambda value: value.value, kind)
    if issubclass(kind, BaseModel):
        return _Codec(lambda value: value.model_dump(mode="json", by_alias=True), kind.model_validate)
    if issubclass(kind, tuple):
        named: Any = kind
        parts = [_codec(hint) for hint in _hints(kind, named._fields)]
        return _fixed(lambda values: named(*values), parts, optional=len(named._field_defaults))
    if dataclasses.is_dataclass(kind):
        return _dataclass(kind)
    if hasattr(kind, "STATE"):
        return _Codec(lambda value: attributes(value, kind.STATE), lambda data: _object(kind, data))
    allowed = "numbers, words, arrays, enumerations, list, tuple, dict, named tuples, dataclasses, models"
    raise TypeError(f"a checkpoint can't keep values of the type {kind!r}; allowed: {allowed}, or its STATE")


def _hints(kind: Any, names: Iterable[str]) -> list[Any]:
    hints = typing.get_type_hints(kind, include_extras=True)
    return [hints[name] for name in names]


def _object(kind: Any, data: object) -> Any:
    made = kind()
    set_attributes(made, kind.STATE, data)
    return made


def _dataclass(kind: Any) -> _Codec:
    names = [field.name for field in dataclasses.fields(kind) if field.init]
    codecs = [_codec(hint) for hint in _hints(kind, names)]
    inner = _fixed(lambda values: kind(**dict(zip(names, values, strict=True))), codecs)
    return _Codec(lambda value: inner.write([getattr(value, name) for name in names]), inner.read)


def _exactly(kind: type) -> _Codec:
    def read(data: object) -> object:
        if type(data) is not kind:
            raise TypeError(f"{_shown(data)} is no {kind.__name__}")
        if isinstance(data, str) and len(data) > MAX_TEXT_LETTERS:
            raise ValueError(f"a word of {len(data)} characters")
        if isinstance(data, int) and abs(data) > 2**128:
            raise ValueError("a number of more than 128 bits")
        return data

    return _Codec((lambda _: None) if kind is types.NoneType else kind, read)


def _any_float(data: object) -> float:
    if type(data) is not float or math.isnan(data):
        raise TypeError(f"{_shown(data)} isn't a floating-point number")
    return data


def _float(data: object) -> float:
    value = _any_float(data)
    if not abs(value) <= MAX_NUMBER:
        raise ValueError(f"{value} is beyond {MAX_NUMBER:g}")
    return value


def _array(dtype: np.dtype[Any], marks: tuple[Any, ...]) -> _Codec:
    shape = next((mark for mark in marks if isinstance(mark, tuple)), None)

    def read(data: object) -> Any:
        if not isinstance(data, np.ndarray) or data.dtype != dtype:
            raise TypeError(f"{_shown(data)} is no array of {dtype}")
        if shape is not None and data.shape != shape:
            raise ValueError(f"an array {data.shape}, needed: {shape}")
        if dtype.kind == "f":
            bad = np.isnan(data) if MAY_BE_INFINITE in marks else ~(np.abs(data) <= MAX_NUMBER)
            if bad.any():
                raise ValueError("an array with an element that isn't a number, or is out of range")
        return data

    return _Codec(lambda value: np.ascontiguousarray(value, dtype=dtype), read)


def _fixed(make: Callable[[Any], Any], parts: list[_Codec], optional: int = 0) -> _Codec:
    """Return the codec of a fixed number of values; older data may lack the last, `optional` ones."""

    def read(data: object) -> Any:
        values = _list(data)
        present = max(len(values), len(parts) - optional)
        return make([codec.read(value) for codec, value in zip(parts[:present], values, strict=True)])

    def write(value: Any) -> list[Any]:
        return [codec.write(item) for codec, item in zip(parts, value, strict=True)]

    return _Codec(write, read)


def _many(kind: Any, part: _Codec) -> _Codec:
    def write(value: Any) -> list[Any]:
        return [part.write(item) for item in (sorted(value) if kind is frozenset else value)]

    return _Codec(write, lambda data: kind([part.read(item) for item in _list(data)]))


def _mapping(key: _Codec, value: _Codec) -> _Codec:
    def write(mapping: Any) -> list[Any]:
        return [[key.write(name), value.write(item)] for name, item in mapping.items()]

    def read(data: object) -> dict[Any, Any]:
        pairs = [_list(pair) for pair in _list(data)]
        return {key.read(each): value.read(item) for each, item in pairs}

    return _Codec(write, read)


def _union(kinds: tuple[Any, ...]) -> _Codec:
    """Return the codec of a union: the type is written before the value; None is written as it is."""
    others = [_written_out(kind) for kind in kinds if kind is not types.NoneType]
    codecs = [_codec(other) for other in others]

    def write(value: Any) -> Any:
        if value is None:
            return None
        number = next(
            i for i, other in enumerate(others) if isinstance(value, typing.get_origin(other) or other)
        )
        return [number, codecs[number].write(value)]

    def read(data: Any) -> Any:
        if data is None and len(others) < len(kinds):
            return None
        number, value = _list(data)
        if type(number) is not int or not 0 <= number < len(codecs):
            raise ValueError(f"{_shown(number)} names none of {len(codecs)} types")
        return codecs[number].read(value)

    if len(others) == 1:
        inner = codecs[0]
        return _Codec(
            lambda value: None if value is None else inner.write(value),
            lambda data: None if data is None else inner.read(data),
        )
    return _Codec(write, read)


def _list(data: object) -> list[Any]:
    if not isinstance(data, list):
        raise TypeError(f"{_shown(data)} is no list")
    return data


def _shown(data: object) -> str:
    return f"a {type(data).__name__}" if isinstance(data, list | dict | np.ndarray) else repr(data)[:40]
