"""Keys of a task's file for time-outs, rounds and interrupts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.files.models.model import FileModel
from handcart.networks.graph.aims import Aims, Interrupt, Rounds

from .condition_entry import Conditions

MAX_AIM_S = 1e7
"""Longest time of a run or between rounds, in [s]: some four months."""
Seconds = Annotated[float, Field(gt=0.0, le=MAX_AIM_S)]
RoundCount = Annotated[int, Field(ge=1, le=1_000_000)] | Literal["forever"]


class RoundsEntry(FileModel):
    """Repetition of a task."""

    most: RoundCount = "forever"
    """Number of rounds."""
    every_s: Annotated[float, Field(ge=0.0, le=MAX_AIM_S)] = 0.0
    """Time between the starts of two rounds (default: one after the other)."""


class DueEntry(FileModel):
    """Condition of an interrupt: `every_s` or `battery_below_percent`."""

    every_s: Seconds | None = None
    """Time after which it is due again."""
    battery_below_percent: Annotated[float, Field(gt=0.0, lt=100.0)] | None = None
    """Charge of the battery below which it is due."""

    until_percent: Annotated[float, Field(gt=0.0, le=100.0)] | None = None
    """Charge up to which the robot waits at the interrupt's goal (default: it continues at once)."""

    @model_validator(mode="after")
    def _has_one(self) -> Self:
        below = self.battery_below_percent
        if self.until_percent is not None and (below is None or self.until_percent <= below):
            raise ValueError("until_percent has no lower battery_below_percent; allowed: one above it")
        if (self.every_s is None) is (self.battery_below_percent is None):
            raise ValueError("needs one condition; allowed: every_s or battery_below_percent")
        return self


class InterruptEntry(FileModel):
    """A goal that comes before the task's goal when a condition holds, between two actions."""

    name: str
    """Name in the journal."""
    when: DueEntry
    """The condition."""
    priority: Annotated[int, Field(ge=-1000, le=1000)] = 0
    """One of a higher priority comes before one of a lower one, and interrupts it."""

    def interrupt(self, goals: Sequence[str]) -> Interrupt:
        """Return the interrupt, given the situations of the network that end it."""
        when = self.when
        below, until = when.battery_below_percent, when.until_percent
        return Interrupt(self.name, tuple(goals), when.every_s, below, self.priority, until)


class SituationInterrupt(InterruptEntry):
    """An interrupt of a network that is written."""

    goal: str
    """Situation to be reached first; from there the run continues to the task's goal."""


class ConditionInterrupt(InterruptEntry):
    """An interrupt of a network that is generated."""

    goal: Annotated[Conditions, Field(min_length=1)]
    """Facts that are to hold first; from there the run continues to the task's goal."""


class AimsHead(FileModel):
    """Keys of any task's file."""

    time_out_s: Seconds | None = None
    """Time of a run, or of each of its rounds, after which the goal is abandoned (status 3)."""
    rounds: RoundCount | RoundsEntry | None = None
    """Repetition of a task that ends where it began: a number, `forever`, or `most` and `every_s`."""

    def aims(self, entries: Sequence[InterruptEntry], goals: Callable[[int], Sequence[str]]) -> Aims:
        """Return the aims of the network.

        Args:
            entries: the file's interrupts.
            goals: situations of the network that end an interrupt, by its number.
        """
        interrupts = tuple(entry.interrupt(goals(number)) for number, entry in enumerate(entries))
        return Aims(self.time_out_s, self._rounds(), interrupts)

    def _rounds(self) -> Rounds | None:
        if self.rounds is None:
            return None
        given = self.rounds if isinstance(self.rounds, RoundsEntry) else RoundsEntry(most=self.rounds)
        return Rounds(None if given.most == "forever" else given.most, given.every_s)
