"""Records of a run that wait for a person, from its journal alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .journal_record import JournalContents

Record = Mapping[str, Any]


def waiting(contents: JournalContents) -> dict[int, str]:
    """Return the records of a journal that a person still has to acknowledge, with their reasons.

    These are a GiveUp, and the START of an action that was broken off. A damaged last record waits as well,
    because it may be such a START or the action's result (row D3 of faults.md). Of an action that a GiveUp of
    the run broke off, only the START waits. In a simulated run only a GiveUp waits, because the simulated
    world is restored to its state before the action.

    Returns:
        Reason by the number of the record.
    """
    records = contents.records
    found: dict[int, str] = {}
    started: Record | None = None
    end: Record | None = None
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
            end = record
        elif kind == "ACK":
            found.pop(record["record"], None)
            if started is not None and started["q"] == record["record"]:
                started = None
                found.clear()  # the GiveUp that broke the action off was looked at with it
        elif kind == "EPOCH":  # the run was resumed
            started = None
    if not records or is_simulated(contents):
        return found
    if started is not None:
        ended = None if end is None else found.pop(end["q"], None)
        found[started["q"]] = broken_off(started) + ("" if ended is None else f": {ended}")
    elif contents.torn_at is not None and may_have_begun(records):
        found[len(records)] = f"record {len(records)} is damaged: an action may have begun"
    return found


def may_have_begun(records: Sequence[Record]) -> bool:
    """Return whether the record that follows the given records of a journal can be the START of an action."""
    return records[-1]["kind"] != "END" and any(record["kind"] == "PLAN" for record in records)


def broken_off(start: Record) -> str:
    """Return a message that an action was broken off, given the record of its start."""
    action = start["action"]
    return f"action {start['n']}, {action['do']} from {action['from']}, was broken off"


def is_simulated(contents: JournalContents) -> bool:
    """Return whether a run is that of a simulated robot."""
    return bool(contents.records[0].get("simulated", True))
