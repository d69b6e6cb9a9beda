"""Compilation of the functions that a control loop needs, before the loop begins."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from handcart.robotics.numerics.compiled import ALL_KERNELS, COMPILED_AHEAD, Kernel
from handcart.robotics.numerics.compiling_ahead import compile_modules


def compile_before() -> int:
    """Compile the functions whose argument types are known, and load those compiled on this machine before.

    Only functions of imported modules are included. If the same task was run on this machine before, nothing
    is left to be compiled.

    Returns:
        The number of functions that are ready.
    """
    compile_modules(list(COMPILED_AHEAD))
    for kernel in list(ALL_KERNELS):
        with suppress(AttributeError, OSError):  # numba keeps its cache to itself, and may keep it otherwise
            _load_cached(kernel)
    return sum(bool(kernel.dispatcher.overloads) for kernel in list(ALL_KERNELS))


def _load_cached(kernel: Kernel) -> None:
    """Load the machine code of a function from disk, for all argument types that are there."""
    dispatcher: Any = kernel.dispatcher
    cache = dispatcher._cache
    codegen = dispatcher.targetctx.codegen()
    for key in cache._cache_file._load_index():
        arguments = key[0]
        if key == cache._index_key(arguments, codegen):
            dispatcher.compile(arguments)
