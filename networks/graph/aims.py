"""Aims of a run besides its goal: rounds of a task that repeats, and interrupts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Rounds:
    """Repetition of a task that ends where it began."""

    most: int | None = None
    """Number of rounds; None: for ever."""
    every_s: float = 0.0
    """Time between the starts of two rounds, in [s] of the robot's time; 0: one after the other."""

    def fields(self) -> dict[str, Any]:
        """Return it, ready for JSON."""
        return {"most": self.most, "every_s": self.every_s}


@dataclass(frozen=True)
class Interrupt:
    """A goal that comes before the task's goal when a condition holds."""

    name: str
    goals: tuple[str, ...]
    """Situations that end it; the one with the cheapest route is pursued."""
    every_s: float | None = None
    """Time after which it is due again, in [s] of the robot's time."""
    battery_below: float | None = None
    """Charge of the battery below which it is due, in [%]."""
    priority: int = 0
    """An interrupt of a higher priority comes before one of a lower one."""

    def fields(self) -> dict[str, Any]:
        """Return it, ready for JSON."""
        return {
            "name": self.name,
            "goals": list(self.goals),
            "every_s": self.every_s,
            "battery_below": self.battery_below,
            "priority": self.priority,
        }


@dataclass(frozen=True)
class Aims:
    """All of them; those of a plain task are empty."""

    time_out_s: float | None = None
    """Time of a run, or of each of its rounds, after which the goal is abandoned, in [s]."""
    rounds: Rounds | None = None
    interrupts: tuple[Interrupt, ...] = ()

    def fields(self) -> dict[str, Any]:
        """Return those that are used, ready for JSON."""
        found: dict[str, Any] = {}
        if self.time_out_s is not None:
            found["time_out_s"] = self.time_out_s
        if self.rounds is not None:
            found["rounds"] = self.rounds.fields()
        if self.interrupts:
            found["interrupts"] = [each.fields() for each in self.interrupts]
        return found

    @classmethod
    def of(cls, fields: dict[str, Any]) -> Aims:
        """Return the aims in a journal's header; raises LookupError, TypeError for invalid ones."""
        rounds = fields.get("rounds")
        every = [dict(each) for each in fields.get("interrupts", ())]
        return cls(
            fields.get("time_out_s"),
            None if rounds is None else Rounds(**rounds),
            tuple(Interrupt(**{**each, "goals": tuple(each["goals"])}) for each in every),
        )


NO_AIMS = Aims()
"""Aims of a plain task."""
