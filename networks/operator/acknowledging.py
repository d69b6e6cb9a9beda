"""Acknowledgement by a person of a GiveUp, or of an action that was broken off."""

from __future__ import annotations

from pathlib import Path

from handcart.files.errors import InputError
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalContents
from handcart.networks.journal.retracing import TORN_RECORD
from handcart.networks.journal.waiting import Record, waiting
from handcart.networks.run_files.run_folder import JOURNAL_FILE, read_run_journal


class NothingToAcknowledge(InputError):
    """Error: the record of a journal that was to be acknowledged does not wait for a person."""


def acknowledge(folder: Path, record: int, cause: str | None = None) -> str:
    """Acknowledge a record of a run's journal that waits for a person, and return why it waited.

    The run can then be resumed (rows N13 and U12 of faults.md), in the situation in which the action began.

    Args:
        folder: the run's folder.
        record: number of the record.
        cause: checksum of the record that the person has read, from `cause_of`; None: not compared.

    Raises:
        NoRun: the folder is not that of a run.
        JournalError: the journal cannot be read or written.
        RunAlive: the run is still running.
        NothingToAcknowledge: the record does not wait, was acknowledged before, or has another checksum.
    """
    contents = read_run_journal(folder)
    waits = waiting(contents)
    if record not in waits:
        allowed = ", ".join(map(str, waits)) or "none waits"
        raise NothingToAcknowledge(f"record {record} doesn't wait for a person; allowed: {allowed}")
    of = cause_of(contents, record)
    if cause is not None and cause != of["h"]:
        raise NothingToAcknowledge(
            f"record {record} isn't the one that was read; allowed: its cause's checksum"
        )
    with Journal.go_on(folder / JOURNAL_FILE, contents, "always") as journal:
        fields = {"record": record, "of": of["kind"], "cause": of["h"], "reason": waits[record]}
        journal.append("ACK", contents.records[-1]["t"], {**fields, "stays": True})
    return waits[record]


def cause_of(contents: JournalContents, record: int) -> Record:
    """Return the record number `record` of a journal, for which the run waits until a person acknowledges it.

    Its key `kind` is the kind of the record, and `h` its checksum. A damaged record is replaced by one with
    the checksum of the record before it.
    """
    if record < len(contents.records):
        return contents.records[record]
    return {"kind": TORN_RECORD, "h": contents.records[-1]["h"]}
