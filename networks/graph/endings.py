"""Situations that an action may lead to besides its target."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Ending:
    """Situation that a Success may lead to instead of the action's usual one, with the result that decides
    it.

    A primitive reports one of its results with each Success.
    """

    target: str
    result: str = ""
    """Result by which the primitive reports it."""
    p: float | None = None
    """Probability that an attempt ends so."""


@dataclass(frozen=True)
class FailEnding:
    """Situation that a Fail of an action leads to, decided by its cause."""

    cause: str
    """Name of a `CauseKind`."""
    target: str | None = None
    """The situation; None: it remains as it is."""
    p: float | None = None
    """Probability that an attempt ends so."""
