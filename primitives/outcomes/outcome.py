"""Outcomes of a primitive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .cause_kind import CauseKind
from .causes import UNNAMED
from .residual import Residuals

_MEASURED = object()


@dataclass(frozen=True)
class Success:
    """Outcome: the motion was completed and, if a sensor can observe it, its effect was observed at rest."""

    evidence: Mapping[str, float | str] = field(default_factory=dict)
    result: str = ""
    """Name of the measured result, one of the primitive's `results`; empty for the usual one."""


@dataclass(frozen=True)
class Fail:
    """Outcome: the motion was not completed, and by measurement everything is as it was at the start, within
    tolerance.
    """

    reason: str
    permanent: bool
    residuals: Residuals
    _proof: object = field(default=None, repr=False, compare=False)
    cause: CauseKind = UNNAMED
    """Kind of cause that ended the motion."""

    def __post_init__(self) -> None:
        if self._proof is not _MEASURED:
            raise TypeError("a Fail must be measured: let the framework restore, measure and report it")


@dataclass(frozen=True)
class GiveUp:
    """Outcome: only a person can help; the robot holds still."""

    reason: str
    residuals: Residuals = field(default_factory=Residuals)
    cause: CauseKind = UNNAMED
    """Kind of cause that ended the motion."""


Outcome = Success | Fail | GiveUp


def fail_if_restored(
    reason: str, permanent: bool, residuals: Residuals, cause: CauseKind = UNNAMED
) -> Fail | GiveUp:
    """Return the outcome of a motion that was undone: a Fail if every residual is within its limit, otherwise
    a GiveUp.

    Args:
        reason: why the motion could not be completed.
        permanent: True if trying again makes no sense.
        residuals: measured differences from the state at the start, each with its limit.
        cause: kind of cause that ended the motion.
    """
    if beyond := residuals.beyond:
        return GiveUp(f"{reason}; and not restored: {beyond.words_with_limits}", residuals, cause)
    return Fail(reason, permanent, residuals, _MEASURED, cause)
