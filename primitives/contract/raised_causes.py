"""Causes that a primitive can raise, read from its code and the code that it calls."""

from __future__ import annotations

import dis
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from types import CodeType, FunctionType, ModuleType
from typing import Any

from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause_kind import CauseKind

from .action_primitive import ActionPrimitive
from .attempt import attempt

OWN_ROOM = "handcart.primitives"
NOT_FOLLOWED = (ActionPrimitive, *ActionPrimitive.__mro__[1:])
"""Classes whose methods belong to the framework, not to a primitive."""


@cache
def causes_of(kind: type[ActionPrimitive]) -> tuple[CauseKind, ...]:
    """Return the causes of a Fail or GiveUp that occur in the code of a primitive, in alphabetical order.

    The code is that of the primitive's class, and of all functions and classes used there, if they are in
    `handcart.primitives` or in the packages of the class and its base classes. Causes with which any
    primitive may fail, such as a time-out, are not included (`framework_causes` returns them).
    """
    packages = {item.__module__.partition(".")[0] for item in kind.__mro__} - {"builtins", "handcart"}
    return _sorted(_Walk(packages).causes_from(kind))


@cache
def framework_causes() -> tuple[CauseKind, ...]:
    """Return the causes with which an attempt of any primitive may fail or give up, such as a time-out."""
    return _sorted({*_Walk(set()).causes_from(attempt), *causes.OUTSIDE_CAUSES})


def possible_causes(kind: type[ActionPrimitive]) -> tuple[CauseKind, ...]:
    """Return all causes with which an attempt of a primitive may fail or give up, in alphabetical order."""
    return _sorted({*causes_of(kind), *framework_causes()})


def _sorted(found: set[CauseKind]) -> tuple[CauseKind, ...]:
    return tuple(sorted(found))


class _Walk:
    """Walk through functions and classes, each once, that collects the causes they name."""

    def __init__(self, packages: set[str]) -> None:
        self._packages = packages
        self._seen: set[int] = set()
        self._found: set[CauseKind] = set()

    def causes_from(self, root: Any) -> set[CauseKind]:
        """Return the causes named in a function or class, and in what it calls."""
        waiting = [root]
        while waiting:
            waiting += self._followed(waiting.pop())
        return self._found

    def _followed(self, value: Any) -> Iterator[Any]:
        if isinstance(value, CauseKind):
            self._found.add(value)
            return
        value = getattr(value, "__wrapped__", value)
        if id(value) in self._seen or not self._is_own(value):
            return
        self._seen.add(id(value))
        if isinstance(value, type):
            for item in value.__mro__:
                if item not in NOT_FOLLOWED and self._is_own(item):
                    yield from (_function(member) for member in [*vars(item).values()])
        elif isinstance(value, FunctionType):
            yield from _named(value.__code__, value.__globals__)

    def _is_own(self, value: Any) -> bool:
        module = getattr(value, "__module__", None) or ""
        return module.startswith(f"{OWN_ROOM}.") or module.partition(".")[0] in self._packages


def _function(member: Any) -> Any:
    """Return the function behind a method, property or cached property."""
    for name in ("__func__", "fget", "func"):
        member = getattr(member, name, member)
    return member


def _named(code: CodeType, names: dict[str, Any]) -> Iterator[Any]:
    """Yield what a function's code names: globals, attributes of modules, and late imports."""
    module: ModuleType | None = None
    steps = list(dis.get_instructions(code))
    for at, step in enumerate(steps):
        if step.opname == "IMPORT_NAME":
            module = _imported(step.argval, steps[at - 2].argval, names)
        elif step.opname == "IMPORT_FROM":
            yield getattr(module, step.argval, None)
        elif "GLOBAL" in step.opname:
            found = names.get(step.argval)
            module = found if isinstance(found, ModuleType) else module
            yield found
        elif step.opname in ("LOAD_ATTR", "LOAD_METHOD") and module is not None:
            yield vars(module).get(step.argval)
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _named(inner, names)


def _imported(name: str, level: int, names: dict[str, Any]) -> ModuleType | None:
    """Return the module of a late import, relative by `level`; None if it cannot be imported."""
    try:
        return import_module("." * level + name, names.get("__package__"))
    except ImportError:
        return None
