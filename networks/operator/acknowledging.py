"""A person's word that a GiveUp, or an action that was broken off, was seen to."""

from __future__ import annotations

from pathlib import Path

from handcart.files.errors import InputError
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.retracing import TORN
from handcart.networks.journal.waiting import waiting
from handcart.networks.runs.run_folder import JOURNAL, read_run_journal


class NothingToAcknowledge(InputError):
    """That record doesn't wait for a person."""


def acknowledge(folder: Path, record: int) -> str:
    """Note in a run's journal that a person has seen to what waits for one; gives why it waits (N13, U12).

    Raises:
        NoRun: it is no run's folder.
        JournalError: the journal can't be read or written.
        RunAlive: the run goes on.
        NothingToAcknowledge: that record doesn't wait, or was acknowledged before.
    """
    contents = read_run_journal(folder)
    waits = waiting(contents)
    if record not in waits:
        allowed = ", ".join(map(str, waits)) or "none waits"
        raise NothingToAcknowledge(f"record {record} doesn't wait for a person; allowed: {allowed}")
    whole = record < len(contents.records)
    of = contents.records[record] if whole else {"kind": TORN, "h": contents.records[-1]["h"]}
    with Journal.go_on(folder / JOURNAL, contents, "always") as journal:
        fields = {"record": record, "of": of["kind"], "cause": of["h"], "reason": waits[record]}
        journal.append("ACK", contents.records[-1]["t"], fields)
    return waits[record]
