"""Why an attempt failed: from the check that found it down to the reading that decided."""

from __future__ import annotations

from dataclasses import dataclass
from traceback import walk_tb
from types import FrameType

from handcart.backends.backend import CommandError, RobotFault
from handcart.backends.capabilities.missing_capability import MissingCapability
from handcart.backends.robot.robot_errors import MissingSensor, StaleReading

from . import causes
from .cause_kind import CauseKind
from .discrepancy import Discrepancy, Measured, NeedsPerson

FRAMEWORK_METHODS = ("observe", "motion", "watch", "effect", "restore", "finish")
"""The methods of a primitive that the framework calls."""
FRAMEWORK_MODULES = {"py_trees"}
"""Modules whose functions are not reported as the source of an exception; the framework's modules add
themselves.
"""
CAUSES_OF_EXCEPTIONS: tuple[tuple[type[Exception], CauseKind], ...] = (
    (CommandError, causes.ROBOT_FAULT),
    (RobotFault, causes.ROBOT_FAULT),
    (StaleReading, causes.SENSOR_FAULT),
    (MissingCapability, causes.UNSUITABLE),
    (MissingSensor, causes.UNSUITABLE),
    (TimeoutError, causes.TIME_OUT),
)
"""Kinds of causes of exceptions that carry no kind; all other exceptions count as errors in the code."""
MAX_CALLS = 12  # calls that are kept


@dataclass(frozen=True)
class Cause:
    """Cause that ended a motion, or that ended the restoring of the start after a failed motion."""

    reason: str
    """Message for people."""
    check: str
    """Method of the primitive that found it, or another source: rest, push, following, supervision,
    framework.
    """
    calls: tuple[str, ...] = ()
    """Functions from the check down to the function that raised."""
    measured: Measured | None = None
    """Deciding reading; None if no reading decided."""
    fault: str = ""
    """Class of the exception, if the cause is a fault in the code; otherwise empty."""
    restoring: bool = False
    """True if it ended the way back, or withdrawing."""
    kind: CauseKind = causes.UNNAMED
    """Kind of cause."""


def cause_of(error: Exception, restoring: bool) -> Cause:
    """Return the cause behind an exception that left a primitive.

    Args:
        error: the caught exception, with its traceback.
        restoring: whether the exception was raised on the way back to the start, or as the hand withdrew.
    """
    frames = [frame for frame, _ in walk_tb(error.__traceback__)]
    calls = [frame.f_code.co_qualname for frame in frames if not _is_framework(frame)]
    found_by = next((f.f_code.co_name for f in frames if f.f_code.co_name in FRAMEWORK_METHODS), "")
    known = error if isinstance(error, Discrepancy | NeedsPerson) else None
    check = getattr(error, "check", "") or found_by
    return Cause(
        known.reason if known else str(error),
        check or ("restore" if restoring else "framework"),
        tuple(calls[:MAX_CALLS]),
        known.measured if known else None,
        "" if known else type(error).__name__,
        restoring,
        kind_of(error),
    )


def kind_of(error: Exception) -> CauseKind:
    """Return the kind of cause to which an exception that ended a motion is attributed, such as a code
    error.
    """
    if isinstance(error, Discrepancy | NeedsPerson):
        return error.cause
    return next((kind for of, kind in CAUSES_OF_EXCEPTIONS if isinstance(error, of)), causes.CODE_ERROR)


def _is_framework(frame: FrameType) -> bool:
    module = str(frame.f_globals.get("__name__", ""))
    inner = frame.f_code.co_name.startswith("<")  # lambdas and comprehensions have no useful name
    return inner or module.partition(".")[0] in FRAMEWORK_MODULES or module in FRAMEWORK_MODULES
