"""A person's word that a GiveUp was seen to."""

from __future__ import annotations

from pathlib import Path

from files.errors import InputError

from .journal import Journal
from .journal_record import read_journal
from .resuming import JOURNAL


class NothingToAcknowledge(InputError):
    """That record is no GiveUp that waits for a person."""


def acknowledge(folder: Path, record: int) -> str:
    """Note in a run's journal that a person has seen to a GiveUp; gives its reason (rows N13, U12).

    Raises:
        JournalError: the journal can't be read or written.
        NothingToAcknowledge: that record is no GiveUp, or was acknowledged before.
    """
    contents = read_journal(folder / JOURNAL)
    waiting = {
        each["q"]: each
        for each in contents.records
        if each["kind"] == "RESULT" and each["outcome"] == "GiveUp"
    }
    for each in contents.records:
        if each["kind"] == "ACK":
            waiting.pop(each["record"], None)
    if record not in waiting:
        allowed = ", ".join(map(str, waiting)) or "none waits"
        raise NothingToAcknowledge(
            f"record {record} is no GiveUp that waits for a person; allowed: {allowed}"
        )
    seen = waiting[record]
    with Journal.go_on(folder / JOURNAL, contents, "always") as journal:
        fields = {"record": record, "cause": seen["h"], "reason": seen["reason"]}
        journal.append("ACK", contents.records[-1]["t"], fields)
    return str(seen["reason"])
