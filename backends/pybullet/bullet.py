"""Import of Bullet's Python module: reports how to install it, and keeps it from writing to stdout."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from handcart.files.errors import InputError

LAST_WHEEL = (3, 11)  # PyBullet 3.2.7 has no wheel for any later Python


class MissingPyBullet(InputError):
    """Error: PyBullet isn't installed."""

    def __init__(self) -> None:
        here = ".".join(map(str, sys.version_info[:2]))
        how = "install it with: pip install 'handcart[pybullet]'"
        if sys.version_info[:2] > LAST_WHEEL:
            how = (
                f"PyBullet has no wheel for Python {here}; use --backend mujoco, Python 3.11, or build "
                "it from source (10 minutes, needs a C++ compiler): pip install pybullet"
            )
        super().__init__(f"the backend 'pybullet' needs PyBullet, which is not installed; {how}")


class NoWorldJoints(InputError):
    """Error: a world has doors, which the backend `pybullet` does not simulate."""

    def __init__(self, name: str) -> None:
        allowed = "allowed: --backend kinematic, --backend mujoco"
        super().__init__(f"the backend 'pybullet' simulates no doors, and the world has {name!r}; {allowed}")


@contextmanager
def quiet() -> Iterator[None]:
    """Discard the output of C code to stdout and stderr inside this context."""
    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    sys.stderr.flush()
    flush(None)
    kept = [os.dup(stream) for stream in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        yield
    finally:
        flush(None)
        for stream, before in zip((1, 2), kept, strict=True):
            os.dup2(before, stream)
            os.close(before)
        os.close(nowhere)


@cache
def bullet() -> ModuleType:
    """Return the module `pybullet`; raises `MissingPyBullet`."""
    if find_spec("pybullet") is None:
        raise MissingPyBullet
    with quiet():
        return import_module("pybullet")
