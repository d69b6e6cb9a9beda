"""The robot's clock in place of the wall clock while a behaviour tree is ticked."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import ModuleType
from typing import Any

TREE_LIBRARY = "py_trees"
CLOCK_NAMES = ("time", "monotonic", "perf_counter")
NANOSECONDS_PER_S = 1e9
_robot_time: ContextVar[Callable[[], float] | None] = ContextVar("_robot_time", default=None)


class WallClockError(RuntimeError):
    """Error of a py_trees behaviour, because it reads the wall clock or sleeps within a tick."""


class TickTime(ModuleType):
    """Replacement of the module `time` for py_trees, whose clocks show the robot's time within a tick."""

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the standard library's `time`."""
        return getattr(time, name)

    def sleep(self, seconds: float) -> None:
        """Sleep for a time in [s]; in a tick of a behaviour, raise `WallClockError`."""
        if _robot_time.get() is not None:
            raise WallClockError(f"a behaviour sleeps for {seconds} s in a tick; allowed: return RUNNING")
        time.sleep(seconds)


def _clock(name: str) -> Callable[[], float]:
    """Return the clock `name` of `TickTime`."""

    def read() -> float:
        robot_time = _robot_time.get()
        return float(getattr(time, name)()) if robot_time is None else robot_time()

    return read


def _clock_ns(name: str) -> Callable[[], int]:
    """Return the clock `name`_ns of `TickTime`, in [ns]."""

    def read() -> int:
        robot_time = _robot_time.get()
        return int(getattr(time, f"{name}_ns")() if robot_time is None else NANOSECONDS_PER_S * robot_time())

    return read


TICK_TIME = TickTime("time", "The robot's clock while a tree is ticked; otherwise the standard library's.")
for _name in CLOCK_NAMES:
    setattr(TICK_TIME, _name, _clock(_name))
    setattr(TICK_TIME, f"{_name}_ns", _clock_ns(_name))


@contextmanager
def robot_clock(now: Callable[[], float]) -> Iterator[None]:
    """Replace the wall clock by the robot's time for behaviour trees that this thread ticks in the context.

    Args:
        now: function that returns the robot's time, in [s].
    """
    serve_library()
    token = _robot_time.set(now)
    try:
        yield
    finally:
        _robot_time.reset(token)


_served: dict[str, object] = {"count": 0, "last": None}
"""Number of modules, and the last one imported, when `serve_library` last looked through them.

The number alone stays the same where a module is removed and another one imported.
"""


def serve_library() -> None:
    """Replace the module `time` by the robot's clock (`TickTime`) in each loaded py_trees module that imports
    it.
    """
    count, last = len(sys.modules), sys.modules[next(reversed(sys.modules))]
    if _served["count"] == count and _served["last"] is last:
        return  # each tick of a tree asks
    _served.update(count=count, last=last)
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == TREE_LIBRARY and vars(module).get("time") is time:
            vars(module)["time"] = TICK_TIME
