"""Typed access to numba, whose import takes most of a second and waits for the first computation."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, update_wrapper
from typing import Any, NamedTuple, TypeVar, cast
from weakref import WeakSet

Function = TypeVar("Function", bound=Callable[..., Any])


class Fields(NamedTuple):
    """Type of an argument that is a named tuple, for functions that numba compiles."""

    kind: type
    """Class of the tuple."""
    types: str
    """Types of its fields in numba's notation, such as "(f8[:,::1], i8)"."""


Arguments = str | tuple[str | Fields, ...]
"""Argument types of a compiled function: in numba's notation together, or one by one."""

COMPILED_AHEAD: dict[str, list[tuple[Kernel, Arguments]]] = {}
"""Functions that another process compiles early, by the module that asks, with their argument types."""


ANY_ORDER = {"reassoc", "contract", "arcp", "nsz"}
"""Permissions for LLVM: it may reorder sums and products, but not assume that a value is impossible."""

WAITING_LISTENERS: list[Callable[[], None]] = []
"""Functions that begin to listen to numba; called as numba is imported for the first kernel."""


class Kernel:
    """Function that numba compiles to machine code on its first call; other compiled functions may call it.

    Its arguments have to be given by position.
    """

    def __init__(self, function: Callable[..., Any], options: Mapping[str, Any] | None = None) -> None:
        """Prepare a function for numba without compiling it; `options` are numba's."""
        update_wrapper(self, function)
        self._function, self._options = function, dict(options or {})
        ALL_KERNELS.add(self)

    @cached_property
    def dispatcher(self) -> Any:
        """Function as compiled by numba; its machine code is cached on disk for the next process, if
        possible.
        """
        import numba

        for listen in WAITING_LISTENERS:
            listen()
        WAITING_LISTENERS.clear()
        try:
            return numba.njit(cache=True, **self._options)(self._function)
        except RuntimeError:  # neither beside the source nor at home
            return numba.njit(**self._options)(self._function)

    @property
    def _numba_type_(self) -> Any:
        """Type of the function within a compiled caller."""
        return self.dispatcher._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        """Call the compiled function."""
        return self.dispatcher(*arguments)

    def __reduce__(self) -> str | tuple[Any, ...]:
        """Pickle like a function: by its name, if it has one in its module."""
        name = self._function.__qualname__
        return (Kernel, (self._function, self._options)) if "<locals>" in name else name


ALL_KERNELS: WeakSet[Kernel] = WeakSet()
"""All functions that are compiled on their first call, of the modules imported so far."""


def compiled(function: Function) -> Function:
    """Return `function` so that its first call compiles it to machine code, which is cached on disk."""
    return cast(Function, Kernel(function))


def compiled_fast(function: Function) -> Function:
    """Return `function` so that its first call compiles it to machine code with faster, less strict
    arithmetic.

    Sums may be computed in any order, and divisions by zero are not checked. Infinity and NaN keep their
    meaning. The machine code is cached on disk.
    """
    return cast(Function, Kernel(function, {"error_model": "numpy", "fastmath": ANY_ORDER}))


def compiled_for(arguments: Arguments) -> Callable[[Function], Function]:
    """Return a decorator like `compiled` that also declares argument types, for functions that are slow to
    compile.

    With known types another process can compile the function early; see `compiling_ahead`.

    Args:
        arguments: types in numba's notation, such as "(f8[:,::1], i8)".
    """

    def compiles(function: Function) -> Function:
        kernel = Kernel(function)
        compile_early(kernel, arguments, function.__module__)
        return cast(Function, kernel)

    return compiles


def compile_early(kernel: Callable[..., Any], arguments: Arguments, module: str) -> None:
    """Declare argument types with which another process may compile a function before its first call.

    The other process compiles the function only if `module` has been imported. This module may differ from
    the one that contains the function, so that programs that never call the function do not compile it.

    Args:
        kernel: the compiled function.
        arguments: argument types as for `compiled_for`.
        module: name of the module that calls the function.
    """
    COMPILED_AHEAD.setdefault(module, []).append((cast(Kernel, kernel), arguments))


@contextmanager
def hearing_of_compiling(heard: Callable[[bool], None]) -> Iterator[None]:
    """Call `heard` within a context with True when compiling begins, and with False when it ends.

    Loading code that is cached on disk is not reported. Numba is not imported by this context manager: it
    listens from the first call of a `Kernel` on.
    """
    ended: list[Callable[[], None]] = []

    def listen() -> None:
        ended.append(_listen(heard))

    if "numba" in sys.modules:
        listen()
    else:
        WAITING_LISTENERS.append(listen)
    try:
        yield
    finally:
        if listen in WAITING_LISTENERS:
            WAITING_LISTENERS.remove(listen)
        for end in ended:
            end()


def _listen(heard: Callable[[bool], None]) -> Callable[[], None]:
    """Register `heard` with numba; return a function that removes it again."""
    from numba.core import event

    class Listener(event.Listener):
        """Counts compilations; functions compiled on behalf of a caller count with the caller."""

        depth = 0

        def on_start(self, _: object) -> None:
            self.depth += 1
            if self.depth == 1:
                heard(True)

        def on_end(self, _: object) -> None:
            self.depth -= 1
            if not self.depth:
                heard(False)

    listener, events = Listener(), cast(Any, event)
    events.register(_COMPILE, listener)
    return lambda: events.unregister(_COMPILE, listener)


_COMPILE = "numba:compile"
