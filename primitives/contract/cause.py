"""Why an attempt failed: from the check that found it down to the reading that decided."""

from __future__ import annotations

from dataclasses import dataclass
from traceback import walk_tb
from types import FrameType

from .discrepancy import Discrepancy, Measured, NeedsPerson

CHECKS = ("observe", "motion", "watch", "effect", "restore", "finish")
"""The methods of a primitive that the framework calls."""
FRAMEWORK = {"py_trees"}
"""Modules whose functions aren't told as what raised; each of the framework's names itself."""
DEEPEST = 12  # calls that are kept


@dataclass(frozen=True)
class Cause:
    """What ended a motion, or a way back."""

    reason: str
    """In words that a person understands."""
    check: str
    """Which method of the primitive found it, or who else: rest, push, following, supervision, framework."""
    calls: tuple[str, ...] = ()
    """Functions from there down to the one that raised."""
    measured: Measured | None = None
    """The reading that decided, where one did."""
    fault: str = ""
    """The exception's class, where it was a fault in the code."""
    restoring: bool = False
    """Whether it was the way back, or withdrawing, that ended so."""


def cause_of(error: Exception, restoring: bool) -> Cause:
    """The cause behind an exception that left a primitive.

    Args:
        error: caught, its traceback complete.
        restoring: whether the way back, or withdrawing, raised it.
    """
    frames = [frame for frame, _ in walk_tb(error.__traceback__)]
    calls = [frame.f_code.co_qualname for frame in frames if not _is_framework(frame)]
    found_by = next((f.f_code.co_name for f in frames if f.f_code.co_name in CHECKS), "")
    known = error if isinstance(error, Discrepancy | NeedsPerson) else None
    check = getattr(error, "check", "") or found_by
    return Cause(
        known.reason if known else str(error),
        check or ("restore" if restoring else "framework"),
        tuple(calls[:DEEPEST]),
        known.measured if known else None,
        "" if known else type(error).__name__,
        restoring,
    )


def _is_framework(frame: FrameType) -> bool:
    module = str(frame.f_globals.get("__name__", ""))
    inner = frame.f_code.co_name.startswith("<")  # lambdas and comprehensions tell nothing
    return inner or module.partition(".")[0] in FRAMEWORK or module in FRAMEWORK
