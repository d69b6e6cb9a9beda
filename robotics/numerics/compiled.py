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
    """Argument type of a compiled function: a named tuple."""

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
    """A function that is compiled to machine code on its first call; compiled ones may call it, too.

    Its arguments are positional.
    """

    def __init__(self, function: Callable[..., Any], options: Mapping[str, Any] | None = None) -> None:
        """Prepare a function for numba without compiling it; `options` are numba's."""
        update_wrapper(self, function)
        self._function, self._options = function, dict(options or {})
        ALL_KERNELS.add(self)

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher; its machine code is cached on disk for the next process, if there is room for
        it.
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
    """Compile `function` to machine code on its first call; kept on disk for the next process."""
    return cast(Function, Kernel(function))


def compiled_fast(function: Function) -> Function:
    """Compile a function like `compiled`, with sums in any order and without checks for division by zero.

    Infinity and NaN keep their meaning.
    """
    return cast(Function, Kernel(function, {"error_model": "numpy", "fastmath": ANY_ORDER}))


def compiled_for(arguments: Arguments) -> Callable[[Function], Function]:
    """Compile a slow-to-compile function with known argument types, so that another process can start on it
    early.

    See `compiling_ahead`.

    Args:
        arguments: such as "(f8[:,::1], i8)".
    """

    def compiles(function: Function) -> Function:
        kernel = Kernel(function)
        compile_early(kernel, arguments, function.__module__)
        return cast(Function, kernel)

    return compiles


def compile_early(kernel: Callable[..., Any], arguments: Arguments, module: str) -> None:
    """Let another process start early on a compiled function, wherever `module` has been imported.

    `arguments` are those of `compiled_for`. For functions that few users of their own module call.
    """
    COMPILED_AHEAD.setdefault(module, []).append((cast(Kernel, kernel), arguments))


@contextmanager
def hearing_of_compiling(heard: Callable[[bool], None]) -> Iterator[None]:
    """Call `heard` with True when compiling begins and with False when it ends; not for code cached on disk.

    Numba is not imported for it: listening begins with the first kernel that is called.
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
