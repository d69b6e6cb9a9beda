"""A run that broke off: what is known of it, and how it goes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .checkpoint import Checkpoint, load_checkpoint
from .journal_record import JournalContents, read_journal
from .network import ActionNetwork
from .retracing import NeedsOperator, Standing, standing

JOURNAL = "journal.jsonl"


@dataclass(frozen=True)
class Past:
    """What a run's folder holds, read once."""

    folder: Path
    contents: JournalContents
    standing: Standing
    checkpoint: Checkpoint | None
    recovered: Mapping[str, Any] | None
    """The RESULT that the checkpoint holds and the journal lacks: a crash came in between."""

    @property
    def last(self) -> int:
        """Number of the journal's last whole record."""
        return len(self.contents.records) - 1

    @property
    def to_tell(self) -> list[tuple[str, Mapping[str, Any]]]:
        """Records that the journal gets before the run goes on."""
        records: list[tuple[str, Mapping[str, Any]]] = []
        if self.recovered is not None:
            records.append(("RESULT", {**self.recovered, "recovered": True}))
        doubt = self.standing.in_doubt
        records.append(("EPOCH", {"after": self.last, "in_doubt": None if doubt is None else doubt["n"]}))
        return records

    def words(self) -> list[str]:
        """What is known, expected and unknown, and what happens next, a line each."""
        here, doubt = self.standing, self.standing.in_doubt
        lines = [
            f"known: record {self.last}; situation {here.route.situation}, {here.started} actions started, "
            f"{here.fails} failed"
        ]
        if self.contents.torn_at is not None:
            lines.append(f"torn: the journal's tail from byte {self.contents.torn_at} on is set aside")
        if self.recovered is not None:
            lines.append(
                f"recovered: action {self.recovered['n']} had ended with {self.recovered['outcome']}"
            )
        if doubt is not None:
            what = doubt["action"]
            lines.append(f"unknown: how far action {doubt['n']}, {what['do']} from {what['from']}, had come")
        return lines


def read_past(folder: Path, network: ActionNetwork) -> Past:
    """What is known of the run in a folder.

    Raises:
        JournalError: the journal can't be read, or is damaged inside.
        NotAState: the checkpoint is none.
        NeedsOperator: the journal doesn't fit the task, or the run gave up and nobody has acknowledged that.
    """
    contents = read_journal(folder / JOURNAL)
    here = standing(network, contents.records)
    if here.gave_up is not None:
        record = here.gave_up
        how = f"when all is as it was before that action: handcart ack {folder} {record['q']}"
        raise NeedsOperator(f"the run gave up: {record['reason']}; {how}")
    checkpoint = load_checkpoint(folder)
    recovered = None
    if checkpoint is not None and checkpoint.result["n"] > here.done:
        recovered = checkpoint.result
        here = standing(
            network, [*contents.records, {"kind": "RESULT", "q": len(contents.records), **recovered}]
        )
    return Past(folder, contents, here, checkpoint, recovered)


def task_of(folder: Path) -> Mapping[str, Any]:
    """The header of a run's journal: task, settings, backend, seed.

    Raises:
        JournalError: the journal can't be read.
        NeedsOperator: there is none, or no task stands in it.
    """
    records = read_journal(folder / JOURNAL).records
    if not records or records[0]["kind"] != "RUN" or "task_path" not in records[0]:
        raise NeedsOperator(f"{folder / JOURNAL} doesn't tell which task was run")
    return records[0]
