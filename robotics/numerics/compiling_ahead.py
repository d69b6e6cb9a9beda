"""Compilation by other processes of the functions that a first run needs later."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, cast

from handcart.robotics.numerics.compiled import COMPILED_AHEAD, Arguments, Fields, hearing_of_compiling

MAX_HELPERS = 3  # processes besides this one


@contextmanager
def compiling_ahead() -> Iterator[None]:
    """Start processes that compile declared functions on other cores, once a compilation begins in this
    context.

    Modules imported last come first. This process finds the compiled code on disk when it needs it. With a
    single core nothing is started; if processes can't be started, all is compiled here. The processes end
    with this process.
    """
    begun: list[subprocess.Popen[bytes]] = []
    asked = False

    def heard(compiling: bool) -> None:
        nonlocal asked
        if compiling and not asked:
            asked = True
            with suppress(OSError):
                begun.extend(_begin(list(COMPILED_AHEAD)))

    with hearing_of_compiling(heard):
        try:
            yield
        finally:
            for popen in begun:
                popen.kill()
            for popen in begun:
                popen.communicate()


def compile_modules(modules: list[str]) -> None:
    """Import modules, and compile the functions that they declared by `compiled_for` or `compile_early`.

    In each module the last declared function is compiled first.
    """
    for name in modules:
        import_module(name)
        for kernel, arguments in reversed(COMPILED_AHEAD.get(name, [])):
            kernel.dispatcher.compile(types_of(arguments))


def types_of(arguments: Arguments) -> tuple[Any, ...]:
    """Return numba's types for the argument types that a caller passes to `compiled_for`."""
    from numba.core.sigutils import normalize_signature

    if isinstance(arguments, str):
        found: tuple[Any, ...] = cast(Any, normalize_signature)(arguments)[0]
        return found
    return tuple(
        _tuple_of(argument) if isinstance(argument, Fields) else types_of(f"({argument},)")[0]
        for argument in arguments
    )


def _tuple_of(fields: Fields) -> Any:
    """Return numba's type of a named tuple."""
    from numba.core.types import BaseTuple

    return cast(Any, BaseTuple).from_types(types_of(fields.types), fields.kind)


def _begin(modules: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """Yield processes for modules in the order in which they were imported."""
    modules = sorted(modules, key=_asks_for_others)
    count = min(MAX_HELPERS, _cores() - 1, len(modules))
    for number in range(count):
        # -P: nothing is imported from the current folder
        words = [sys.executable, "-P", "-m", __name__, *modules[::-1][number::count]]
        quiet = subprocess.DEVNULL
        yield subprocess.Popen(
            words, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet, start_new_session=True
        )


def _asks_for_others(module: str) -> bool:
    """Return whether a module asked for functions of other modules: it will call them soon."""
    return any(kernel.__module__ != module for kernel, _ in COMPILED_AHEAD.get(module, ()))


def _cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _end_with_parent() -> None:
    """Wait until the parent process, which holds the other end of standard input, ends."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    os._exit(0)


if __name__ == "__main__":
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if hasattr(os, "nice"):
        os.nice(10)  # beside a robot that moves
    compile_modules(sys.argv[1:])
