"""Aims of a run besides its goal: rounds of a task that repeats, and interrupts."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import time
from itertools import chain
from typing import Any


@dataclass(frozen=True)
class Rounds:
    """Rule for how often, and when, a task that ends in its start situation is repeated."""

    most: int | None = None
    """Number of rounds; None: unlimited."""
    every_s: float = 0.0
    """Time between the starts of two rounds, in [s] of the robot's time; 0: one after the other."""
    at: tuple[time, ...] = ()
    """Times of day at which rounds begin; none: as `every_s` says."""

    def fields(self) -> dict[str, Any]:
        """Return number, period and times of day of a task's repetitions ("rounds") as fields, ready for
        JSON.
        """
        return {"most": self.most, "every_s": self.every_s, **_at_fields(self.at)}


@dataclass(frozen=True)
class Interrupt:
    """A goal that a run pursues before the task's goal whenever a condition holds, such as a low battery."""

    name: str
    goals: tuple[str, ...]
    """Situations that end it; the one with the cheapest route is pursued."""
    every_s: float | None = None
    """Time after which it is due again, in [s] of the robot's time; None: it depends on another condition."""
    battery_below: float | None = None
    """Charge of the battery below which it is due, in [%]; None: it depends on another condition."""
    priority: int = 0
    """An interrupt of a higher priority comes before one of a lower one."""
    battery_until: float | None = None
    """Charge up to which the robot waits once the interrupt's goal is reached, in [%]; None: it continues at
    once.
    """
    at: tuple[time, ...] = ()
    """Times of day at which it is due; none: it depends on another condition."""

    def fields(self) -> dict[str, Any]:
        """Return name, goals, conditions and priority of the interrupt as fields for JSON."""
        found = {
            "name": self.name,
            "goals": list(self.goals),
            "every_s": self.every_s,
            "battery_below": self.battery_below,
            "priority": self.priority,
            **_at_fields(self.at),
        }
        return found if self.battery_until is None else {**found, "battery_until": self.battery_until}


@dataclass(frozen=True)
class Aims:
    """Time-out, rounds (repetitions) and interrupts of a task; a plain task has none of them."""

    time_out_s: float | None = None
    """Time of a run, or of each of its rounds, after which the goal is abandoned, in [s]; None: never."""
    rounds: Rounds | None = None
    interrupts: tuple[Interrupt, ...] = ()

    def fields(self) -> dict[str, Any]:
        """Return the aims of a task that are set (time-out, rounds and interrupts) as fields for JSON."""
        found: dict[str, Any] = {}
        if self.time_out_s is not None:
            found["time_out_s"] = self.time_out_s
        if self.rounds is not None:
            found["rounds"] = self.rounds.fields()
        if self.interrupts:
            found["interrupts"] = [interrupt.fields() for interrupt in self.interrupts]
        return found

    def words(self) -> dict[str, str]:
        """Return the time-out, rounds and interrupts of a task, as far as it has them, as text by name."""
        found: dict[str, str] = {}
        if self.time_out_s is not None:
            found["time-out"] = f"{self.time_out_s:g} s{' for each round' if self.rounds else ''}"
        if self.rounds is not None:
            every = f", every {self.rounds.every_s:g} s" if self.rounds.every_s else ""
            every = f", at {times_words(self.rounds.at)}" if self.rounds.at else every
            found["rounds"] = f"{self.rounds.most or 'for ever'}{every}"
        if self.interrupts:
            named = (f"{interrupt.name} (priority {interrupt.priority})" for interrupt in self.interrupts)
            found["interrupts"] = ", ".join(named)
        return found

    @classmethod
    def of(cls, fields: dict[str, Any]) -> Aims:
        """Return a task's time-out, rounds (repetitions of the task, such as hourly) and interrupts (goals
        pursued first when a condition holds), read from the header of a run's journal.

        Raises:
            LookupError, TypeError: the header's fields are invalid.
        """
        rounds = fields.get("rounds")
        every = [dict(item) for item in fields.get("interrupts", ())]
        return cls(
            fields.get("time_out_s"),
            None if rounds is None else Rounds(**{**rounds, "at": _times(rounds)}),
            tuple(Interrupt(**{**item, "goals": tuple(item["goals"]), "at": _times(item)}) for item in every),
        )

    @property
    def begins_at(self) -> time | None:
        """Time of day at which a rehearsal (a run on a simulated robot) begins if no other one is given.

        It is the first time of day at which a round (repetition of the task) begins, otherwise the first one
        of an interrupt (goal with priority over the task's); None if neither has times of day.
        """
        of_rounds = self.rounds.at if self.rounds else ()
        of_interrupts = (item for interrupt in self.interrupts for item in interrupt.at)
        return next(chain(of_rounds, of_interrupts), None)


def times_words(times: tuple[time, ...]) -> str:
    """Return times of day as text, such as "08:00, 14:30"."""
    return ", ".join(_short(item) for item in times)


def _short(item: time) -> str:
    return item.isoformat("seconds" if item.second else "minutes")


def _at_fields(times: tuple[time, ...]) -> dict[str, Any]:
    return {"at": [_short(item) for item in times]} if times else {}


def _times(fields: dict[str, Any]) -> tuple[time, ...]:
    return tuple(map(time.fromisoformat, fields.get("at", ())))


NO_AIMS = Aims()
"""Aims of a plain task."""
