"""Find the functions of a code object that read the wall clock."""

from __future__ import annotations

import datetime
import dis
import threading
import time
from collections.abc import Iterator, Mapping
from itertools import pairwise, takewhile
from types import CodeType
from typing import Any, NamedTuple

_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time", "clock_gettime")
CLOCK_FUNCTIONS: tuple[tuple[Any, frozenset[str]], ...] = (
    (time, frozenset({*_CLOCKS, *(f"{clock}_ns" for clock in _CLOCKS), "sleep", "localtime", "gmtime"})),
    (threading, frozenset({"Timer"})),
    (datetime.datetime, frozenset({"now", "utcnow", "today"})),
    (datetime.date, frozenset({"today"})),
)
"""Modules and classes, each with its functions that read the wall clock or wait for a time on it."""
CLOCK_MODULES = {"time": time, "threading": threading, "datetime": datetime}
_FUNCTIONS = [
    getattr(owner, name) for owner, names in CLOCK_FUNCTIONS[:2] for name in names if hasattr(owner, name)
]
_VALUES = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FAST", "LOAD_DEREF", "LOAD_CLOSURE")
_ATTRIBUTES = ("LOAD_ATTR", "LOAD_METHOD")


class ClockRead(NamedTuple):
    """Place in the code (file, line and function) that reads the wall clock."""

    function: str
    """Name in the code, such as `time.monotonic`."""
    file: str
    line: int


def is_clock(value: Any) -> bool:
    """Return whether a value is a function that reads the wall clock, such as `time.monotonic`."""
    return any(value is function for function in _FUNCTIONS)


def codes_of(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object of Python, and all code objects nested in it, such as those of inner functions."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes_of(constant)


def reads_in(code: CodeType, named: Mapping[str, Any]) -> Iterator[ClockRead]:
    """Yield the places where a code object reads the wall clock.

    Args:
        code: code object of a function.
        named: values of the globals and closure variables that it names.
    """
    steps = list(dis.get_instructions(code))
    known = {**named, **_imported(steps)}
    for k, step in enumerate(steps):
        name = step.argval
        line = 0 if step.positions is None else step.positions.lineno or 0
        if step.opname == "IMPORT_FROM" and _reads(_importing(steps[:k]), name):
            yield ClockRead(name, code.co_filename, line)
        if not step.opname.startswith(_VALUES) or not isinstance(name, str) or name not in known:
            continue
        value, words = known[name], name
        if is_clock(value):
            yield ClockRead(words, code.co_filename, line)
        for attribute in takewhile(lambda step: step.opname in _ATTRIBUTES, steps[k + 1 :]):
            words = f"{words}.{attribute.argval}"
            if _reads(value, attribute.argval):
                yield ClockRead(words, code.co_filename, line)
            value = getattr(value, attribute.argval, None) if _is_clock_module(value) else None


def _is_clock_module(value: Any) -> bool:
    return any(value is module for module in CLOCK_MODULES.values())  # arrays can't be asked with ==


def _reads(owner: Any, name: str) -> bool:
    return any(owner is item and name in names for item, names in CLOCK_FUNCTIONS)


def _imported(steps: list[dis.Instruction]) -> dict[str, Any]:
    """Return the modules that a function imports itself, by the local name."""
    return {
        after.argval: CLOCK_MODULES[step.argval]
        for step, after in pairwise(steps)
        if step.opname == "IMPORT_NAME" and step.argval in CLOCK_MODULES and after.opname.startswith("STORE_")
    }


def _importing(steps: list[dis.Instruction]) -> Any:
    """Return the module of the latest import statement."""
    names = [step.argval for step in steps if step.opname == "IMPORT_NAME"]
    return CLOCK_MODULES.get(names[-1]) if names else None
