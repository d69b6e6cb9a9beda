"""Machine code that a first run needs later is made by other processes meanwhile."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, cast

from handcart.robotics.numerics.compiled import AHEAD, hearing_of_compiling

MOST = 3  # processes besides this one


@contextmanager
def compiling_ahead() -> Iterator[None]:
    """Within it, as soon as something is compiled here, the other cores begin with what is needed last.

    What they make is found on disk by whoever needs it then. Where there is one core, nothing happens.
    """
    begun: list[subprocess.Popen[bytes]] = []

    def heard(compiling: bool) -> None:
        if compiling and not begun:
            begun.extend(_begin(list(AHEAD)))

    with hearing_of_compiling(heard):
        try:
            yield
        finally:
            for each in begun:
                each.kill()
                each.wait()


def compile_modules(modules: list[str]) -> None:
    """What `compiled_for` has in those modules, the latest first."""
    for name in modules:
        import_module(name)
        for kernel, arguments in reversed(AHEAD.get(name, [])):
            kernel.dispatcher.compile(types_of(arguments))


def types_of(arguments: str) -> tuple[Any, ...]:
    """Numba's types of what `compiled_for` was told."""
    from numba.core.sigutils import normalize_signature

    found: tuple[Any, ...] = cast(Any, normalize_signature)(arguments)[0]
    return found


def _begin(modules: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """Processes for modules in the order in which they were imported."""
    count = min(MOST, (os.cpu_count() or 1) - 1, len(modules))
    for number in range(count):
        words = [sys.executable, "-m", __name__, *modules[::-1][number::count]]
        quiet = subprocess.DEVNULL
        yield subprocess.Popen(words, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True)


if __name__ == "__main__":
    compile_modules(sys.argv[1:])
