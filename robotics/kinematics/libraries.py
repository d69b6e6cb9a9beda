"""Libraries that only robots with arms need: imported when something of them is first used.

So a module that names an arm costs nothing, and asks for nothing, where there is none.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["fcl", "pin"]


class LazyLibrary:
    """Stands for a library; an attribute that is asked for imports it, and is kept.

    Raises:
        ImportError: at that moment, where the library is missing.
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
