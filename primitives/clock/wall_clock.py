"""Find behaviours and primitives whose code reads the wall clock."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from functools import cache, partial
from pathlib import Path
from types import FunctionType, MethodType, ModuleType
from typing import TYPE_CHECKING, Any

from .clock_reads import ClockRead, codes_of, is_clock, reads_in
from .tick_clock import WallClockError, serve_library

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

ALLOWED_CLOCK = "allowed: robot.time, or Timer and Timeout of py_trees"
TRUSTED_PACKAGES = {"handcart", "pydantic", *sys.stdlib_module_names}
"""Packages whose code is not looked through."""
MAX_DEPTH = 6  # calls from a behaviour's method that are followed


def refuse_wall_clock(nodes: Iterable[Behaviour]) -> None:
    """Reject a behaviour tree before its first tick if the code of a node reads the wall clock.

    Raises:
        WallClockError: a node reads the wall clock; the message names each of these nodes with file, line and
            function.
    """
    found = [words for node in nodes for words in (*wall_clock_reads(type(node)), *_given_reads(node))]
    if found:
        raise WallClockError(f"{'; '.join(dict.fromkeys(found))}; {ALLOWED_CLOCK}")


@cache
def wall_clock_reads(kind: type) -> tuple[str, ...]:
    """Return where the code of a primitive or behaviour reads the wall clock, as text; empty if nowhere."""
    serve_library()
    return tuple(dict.fromkeys(_Search(kind.__name__).in_class(kind)))


def _given_reads(node: Behaviour) -> Iterator[str]:
    """Yield descriptions of the wall-clock reads in the functions that a node was given."""
    for value in vars(node).values():
        yield from _Search(type(node).__name__).in_value(value, "")


class _Search:
    """Search for wall-clock reads in the code of one class and all that it calls; each function and class
    once.
    """

    def __init__(self, owner: str) -> None:
        self._owner = owner
        self._seen = list[Any]()

    def in_class(self, kind: type, depth: int = 0) -> Iterator[str]:
        """Yield descriptions of the wall-clock reads in the methods that a class has or inherits."""
        for base in kind.__mro__:
            if self._is_new(base) and not _is_trusted(base.__module__):
                outer, self._owner = self._owner, base.__name__ if depth else self._owner
                for name, member in tuple(vars(base).items()):  # a model may be built meanwhile
                    yield from self._in_member(name, member, depth)
                self._owner = outer

    def in_value(self, value: Any, package: str, depth: int = 0) -> Iterator[str]:
        """Yield descriptions of the wall-clock reads of a value, such as a function, class or partial.

        Args:
            value: the value.
            package: package of the code that names it; "" if an object was given the value.
            depth: number of calls from the searched class.
        """
        while isinstance(value, partial):
            value = value.func
        if depth > MAX_DEPTH:
            return
        is_near = package in ("", _package_of(value))
        if not package and is_clock(value):
            yield f"{self._owner} was given {value.__name__}"
        elif isinstance(value, type) and (_is_behaviour(value) or (is_near and package)):
            yield from self.in_class(value, depth)
        elif isinstance(value, FunctionType | MethodType) and is_near:
            yield from self._in_function(value, depth)

    def _in_member(self, name: str, member: Any, depth: int) -> Iterator[str]:
        """Yield descriptions of the wall-clock reads of a class attribute: method, property, class or static
        method.
        """
        member = getattr(member, "__func__", member)
        if is_clock(member):
            yield f"{self._owner}.{name} is {member.__name__}"
        both: tuple[Any, ...] = (member,)
        if isinstance(member, property):
            both = member.fget, member.fset
        for function in both:
            while hasattr(function, "__wrapped__"):
                function = function.__wrapped__
            if isinstance(function, FunctionType):
                yield from self._in_function(function, depth)

    def _in_function(self, function: FunctionType | MethodType, depth: int) -> Iterator[str]:
        """Yield descriptions of the wall-clock reads of a function and of all that it names.

        Of a function in `TRUSTED_PACKAGES`, only the closure variables are searched.
        """
        plain: Any = function.__func__ if isinstance(function, MethodType) else function
        if not isinstance(plain, FunctionType) or not self._is_new(plain):
            return
        package = _package_of(plain)
        given = _closure_of(plain)
        if package in TRUSTED_PACKAGES:
            for value in given.values():
                yield from self.in_value(value, "", depth + 1)
            return
        codes = list(codes_of(plain.__code__))
        names = {name for code in codes for name in code.co_names}
        named = {name: plain.__globals__[name] for name in names & plain.__globals__.keys()} | given
        for read in (read for code in codes for read in reads_in(code, named)):
            yield self._words(read)
        for value in (*(plain.__defaults__ or ()), *(plain.__kwdefaults__ or {}).values()):
            if is_clock(value):
                yield self._words(
                    ClockRead(value.__name__, plain.__code__.co_filename, plain.__code__.co_firstlineno)
                )
        for value in (*named.values(), *_members_named(named.values(), names, package)):
            yield from self.in_value(value, package, depth + 1)

    def _words(self, read: ClockRead) -> str:
        return f"{self._owner} reads the wall clock ({read.function}, {Path(read.file).name}:{read.line})"

    def _is_new(self, item: Any) -> bool:
        if any(item is each for each in self._seen):
            return False
        self._seen.append(item)
        return True


def _is_behaviour(kind: type) -> bool:
    """Return whether a class is a behaviour of py_trees, which is only imported where a tree is."""
    library = sys.modules.get("py_trees.behaviour")
    return library is not None and issubclass(kind, library.Behaviour)


def _closure_of(function: FunctionType) -> dict[str, Any]:
    """Return the closure variables of a function that have a value."""
    values = dict[str, Any]()
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        try:
            values[name] = cell.cell_contents
        except ValueError:  # no value yet
            continue
    return values


def _members_named(values: Iterable[Any], names: set[str], package: str) -> Iterator[Any]:
    """Yield the functions and classes that code names in modules of its own package."""
    for module in values:
        if isinstance(module, ModuleType) and module.__name__.partition(".")[0] == package:
            yield from (vars(module)[name] for name in names & vars(module).keys())


def _package_of(value: Any) -> str:
    return str(getattr(value, "__module__", None) or "").partition(".")[0]


def _is_trusted(module: str) -> bool:
    return module.partition(".")[0] in TRUSTED_PACKAGES
