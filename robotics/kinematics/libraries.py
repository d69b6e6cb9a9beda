"""Libraries that only robots with arms need, imported on first use.

So a module that names an arm costs nothing, and needs no library, on a robot without one.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["fcl", "pin"]


class LazyLibrary:
    """Proxy of a library that is imported when one of its attributes is first used.

    Raises:
        ImportError: the library is missing; raised when an attribute is first used.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        found = getattr(import_module(self._name), attribute)
        setattr(self, attribute, found)
        return found


if TYPE_CHECKING:
    import fcl
    import pinocchio as pin
else:
    fcl = LazyLibrary("fcl")
    pin = LazyLibrary("pinocchio")
