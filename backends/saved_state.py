"""The state of a simulated world as bytes: of values, not of programs."""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterable, Mapping
from typing import Any

from files.errors import InputError

OURS = ("backends.", "robotics.", "primitives.")
"""Packages whose classes a saved state may hold."""
_PLAIN = {
    ("builtins", "frozenset"),
    ("builtins", "set"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}


class NotAState(InputError):
    """Bytes that no saved state can be."""


def attributes(thing: object, names: Iterable[str]) -> dict[str, Any]:
    """Some attributes of an object, by name."""
    return {name: getattr(thing, name) for name in names}


def set_attributes(thing: object, values: Mapping[str, Any]) -> None:
    """Give an object back what `attributes` took."""
    for name, value in values.items():
        setattr(thing, name, value)


def pack(state: object) -> bytes:
    """A state as bytes; what is the same object in it stays the same object."""
    return pickle.dumps(state, protocol=5)


def unpack(content: bytes) -> Any:
    """A state from bytes that `pack` made.

    Raises:
        NotAState: they hold something else, such as a function that would run.
    """
    try:
        return _Unpickler(io.BytesIO(content)).load()
    except NotAState:
        raise
    except Exception as error:
        raise NotAState(f"no saved state: {type(error).__name__}: {error}") from None


class _Unpickler(pickle.Unpickler):
    """Makes numbers, arrays and our own value classes, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        found = super().find_class(module, name) if _allowed(module, name) else None
        if (module, name) in _PLAIN or isinstance(found, type):
            return found
        raise NotAState(f"no saved state: it holds {module}.{name}")


def _allowed(module: str, name: str) -> bool:
    return (module, name) in _PLAIN or (module.startswith(OURS) and "." not in name)
