"""What of a run waits for a person, by its journal alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Record = Mapping[str, Any]


def waiting(records: Sequence[Record]) -> dict[int, str]:
    """Record to reason: a GiveUp, or the START of an action that was broken off, that nobody acknowledged.

    Of a simulated run only a GiveUp waits: its world is put back to where the action began.
    """
    found: dict[int, str] = {}
    started: Record | None = None
    for record in records:
        kind = record["kind"]
        if kind == "START":
            started = record
        elif kind in ("RESULT", "NOT_STARTED"):
            started = None
            if record.get("outcome") == "GiveUp":
                found[record["q"]] = str(record["reason"])
        elif kind == "END" and record["outcome"] == "GiveUp" and not found:
            found[record["q"]] = str(record["reason"])
        elif kind == "ACK":
            found.pop(record["record"], None)
            started = None if started and started["q"] == record["record"] else started
        elif kind == "EPOCH":  # somebody went on with it
            started = None
    if started is not None and not _simulated(records):
        found[started["q"]] = broken_off(started)
    return found


def broken_off(start: Record) -> str:
    """A START without a RESULT, in words."""
    action = start["action"]
    return f"action {start['n']}, {action['do']} from {action['from']}, was broken off"


def _simulated(records: Sequence[Record]) -> bool:
    return bool(records[0].get("simulated", True))
