"""Outcomes of a primitive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .cause_kind import CauseKind
from .causes import UNNAMED

_MEASURED = object()


@dataclass(frozen=True)
class Success:
    """The motion was completed and, if a sensor can observe it, its effect was observed at rest."""

    evidence: Mapping[str, float | str] = field(default_factory=dict)
    result: str = ""
    """Which of the primitive's `results` was measured; empty for the usual one."""


@dataclass(frozen=True)
class Fail:
    """It could not be completed, and everything is as it was at the start: measured, within tolerance.

    Only `fail_if_restored` makes one.
    """

    reason: str
    permanent: bool
    residuals: Mapping[str, float]
    _proof: object = field(default=None, repr=False, compare=False)
    cause: CauseKind = UNNAMED
    """Kind of cause that ended the motion."""

    def __post_init__(self) -> None:
        if self._proof is not _MEASURED:
            raise TypeError("a Fail must be measured: let the framework restore, measure and report it")


@dataclass(frozen=True)
class GiveUp:
    """Only a person can help; the robot holds still."""

    reason: str
    residuals: Mapping[str, float] = field(default_factory=dict)
    cause: CauseKind = UNNAMED
    """Kind of cause that ended the motion."""


Outcome = Success | Fail | GiveUp


def fail_if_restored(
    reason: str,
    permanent: bool,
    residuals: Mapping[str, float],
    limits: Mapping[str, float],
    cause: CauseKind = UNNAMED,
) -> Fail | GiveUp:
    """The verdict on a restored robot.

    Args:
        reason: why the motion could not be completed.
        permanent: trying again makes no sense.
        residuals: how far everything measured is from the snapshot, name to size.
        limits: the largest size allowed, under the same names.
        cause: kind of cause that ended the motion.
    """
    off = [name for name in residuals if not residuals[name] <= limits[name]]
    if off:
        words = ", ".join(f"{name} {residuals[name]:.3g} (at most {limits[name]:.3g})" for name in off)
        return GiveUp(f"{reason}; and not restored: {words}", residuals, cause)
    return Fail(reason, permanent, residuals, _MEASURED, cause)
