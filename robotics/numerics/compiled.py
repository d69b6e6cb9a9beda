"""One typed door to numba."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar, cast

import numba
from numba.core import event

Function = TypeVar("Function", bound=Callable[..., Any])

AHEAD: dict[str, list[tuple[Any, str]]] = {}
"""By module: what `compiled_for` has compiled, and for which arguments."""


def compiled(function: Function) -> Function:
    """Compile `function` to machine code on its first call; kept on disk for the next process."""
    return cast(Function, numba.njit(cache=True)(function))


def compiled_for(arguments: str) -> Callable[[Function], Function]:
    """The same where it takes long: with the types that it is called with, another process can begin with it.

    `arguments` as numba has them, such as "(f8[:,::1], i8)"; see `compiling_ahead`.
    """

    def compiles(function: Function) -> Function:
        kernel = compiled(function)
        AHEAD.setdefault(function.__module__, []).append((kernel, arguments))
        return kernel

    return compiles


@contextmanager
def hearing_of_compiling(heard: Callable[[bool], None]) -> Iterator[None]:
    """Call `heard` with True as compiling begins, and with False as it is over; not for what is on disk."""
    listener, events = _Listener(heard), cast(Any, event)
    events.register(_COMPILE, listener)
    try:
        yield
    finally:
        events.unregister(_COMPILE, listener)


_COMPILE = "numba:compile"


class _Listener(event.Listener):
    """What a function calls is compiled while it is: that is one compiling."""

    def __init__(self, heard: Callable[[bool], None]) -> None:
        self._heard, self._depth = heard, 0

    def on_start(self, _: object) -> None:
        self._depth += 1
        if self._depth == 1:
            self._heard(True)

    def on_end(self, _: object) -> None:
        self._depth -= 1
        if not self._depth:
            self._heard(False)
