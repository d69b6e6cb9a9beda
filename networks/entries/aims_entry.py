"""Keys of a task's file for time-outs, rounds and interrupts."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import time
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from handcart.files.models.model import FileModel
from handcart.files.models.schema_words import shown
from handcart.networks.graph.aims import Aims, Interrupt, Rounds

from .condition_entry import Conditions

MAX_AIM_S = 1e7
"""Longest time of a run or between rounds, in [s]: some four months."""
Seconds = Annotated[float, Field(gt=0.0, le=MAX_AIM_S)]
_TIME_OF_DAY = re.compile(r"(?:[01][0-9]|2[0-3]):[0-5][0-9](?::[0-5][0-9])?", re.ASCII)


def read_time_of_day(text: Any) -> time:
    """Return a time of day, written like 17:30 or 17:30:05; raises ValueError for any other text."""
    if isinstance(text, str) and _TIME_OF_DAY.fullmatch(text):
        return time.fromisoformat(text)
    allowed = '"HH:MM" or "HH:MM:SS", from "00:00" to "23:59:59"'
    raise ValueError(f"{shown(text)} is no time of day; allowed: {allowed}")


def _in_order(times: Any) -> Any:
    return [times] if isinstance(times, str) else times


TimeOfDay = Annotated[
    time,
    BeforeValidator(read_time_of_day),
    WithJsonSchema({"type": "string", "pattern": f"^{_TIME_OF_DAY.pattern}$"}),
]
TimesOfDay = Annotated[list[TimeOfDay], BeforeValidator(_in_order), Field(min_length=1, max_length=1000)]
RoundCount = Annotated[int, Field(ge=1, le=1_000_000)] | Literal["forever"]


class RoundsEntry(FileModel):
    """Keys for the repetition of a task, with the number of its rounds and the times at which they begin."""

    most: RoundCount = "forever"
    """Number of rounds."""
    every_s: Annotated[float, Field(ge=0.0, le=MAX_AIM_S)] = 0.0
    """Time between the starts of two rounds (default: one after the other)."""
    at: TimesOfDay | None = None
    """Times of day at which rounds begin, one or a list (default: as `every_s` says)."""

    @model_validator(mode="after")
    def _has_one_rule(self) -> Self:
        if self.at is not None and self.every_s:
            raise ValueError("has both every_s and at; allowed: one of them")
        return self


class DueEntry(FileModel):
    """Condition under which an interrupt (a goal that comes before the task's goal) is due."""

    every_s: Seconds | None = None
    """Time after which it is due again."""
    at: TimesOfDay | None = None
    """Times of day at which it is due, one or a list."""
    battery_below_percent: Annotated[float, Field(gt=0.0, lt=100.0)] | None = None
    """Charge of the battery below which it is due."""

    until_percent: Annotated[float, Field(gt=0.0, le=100.0)] | None = None
    """Charge up to which the robot waits at the interrupt's goal (default: it continues at once)."""

    @model_validator(mode="after")
    def _has_one(self) -> Self:
        below = self.battery_below_percent
        if self.until_percent is not None and (below is None or self.until_percent <= below):
            raise ValueError("until_percent needs battery_below_percent; allowed: a charge above that one")
        if sum(item is not None for item in (self.every_s, self.at, below)) != 1:
            raise ValueError("needs one condition; allowed: every_s, at or battery_below_percent")
        return self


class InterruptEntry(FileModel):
    """Keys of an interrupt in a task file, a goal that is pursued first when a condition holds.

    The condition is checked between two actions.
    """

    name: str
    """Name in the journal."""
    when: DueEntry
    """The condition."""
    priority: Annotated[int, Field(ge=-1000, le=1000)] = 0
    """One of a higher priority comes before one of a lower one, and interrupts it."""

    def interrupt(self, goals: Sequence[str]) -> Interrupt:
        """Return the interrupt that this entry describes; each situation in `goals` fulfils and ends it."""
        when = self.when
        below, until = when.battery_below_percent, when.until_percent
        at = tuple(when.at or ())
        return Interrupt(self.name, tuple(goals), when.every_s, below, self.priority, until, at)


class SituationInterrupt(InterruptEntry):
    """Interrupt (goal pursued before the task's goal, such as charging) in a task file that lists situations.

    The interrupt's goal is one of these situations.
    """

    goal: str
    """Situation to be reached first; from there the run continues to the task's goal."""


class ConditionInterrupt(InterruptEntry):
    """An interrupt (goal that a run pursues before the task's goal) in a task file that states conditions.

    The interrupt's goal is a list of facts. The task's network is generated from the conditions.
    """

    goal: Annotated[Conditions, Field(min_length=1)]
    """Facts that are to hold first; from there the run continues to the task's goal."""


class AimsHead(FileModel):
    """Keys for time-out and repetition ("rounds") of a task, which the file of any task may have."""

    time_out_s: Seconds | None = None
    """Time of a run, or of each of its rounds, after which the goal is abandoned (status 3)."""
    rounds: RoundCount | RoundsEntry | None = None
    """Repetition of a task that ends where it began: a number, `forever`, or `most`, `every_s` and `at`."""

    def aims(self, entries: Sequence[InterruptEntry], goals: Callable[[int], Sequence[str]]) -> Aims:
        """Return the network's aims, which are its time-out, the rounds in which it is repeated, and its
        interrupts.

        Args:
            entries: the file's interrupts.
            goals: function that returns the situations that end an interrupt, given the interrupt's number
                from 0.
        """
        interrupts = tuple(entry.interrupt(goals(number)) for number, entry in enumerate(entries))
        return Aims(self.time_out_s, self._rounds(), interrupts)

    def _rounds(self) -> Rounds | None:
        if self.rounds is None:
            return None
        given = self.rounds if isinstance(self.rounds, RoundsEntry) else RoundsEntry(most=self.rounds)
        most = None if given.most == "forever" else given.most
        return Rounds(most, given.every_s, tuple(given.at or ()))
