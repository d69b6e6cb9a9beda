"""A run that is over (or broke off), read back from its folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

from handcart.networks.journal.journal import JOURNAL_SCHEMA
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.run_files.run_folder import JOURNAL_FILE, NoRun, read_file, read_run_journal
from handcart.networks.run_files.telemetry import RunTrack, load_track

from .journaled_network import JournaledNetwork, network_of

TELEMETRY_FILE = "telemetry.npz"
MAX_TELEMETRY = 256 * 2**20
Record = Mapping[str, Any]


@dataclass(frozen=True)
class PastAction:
    """Action that a past run has started, with its times, outcome and end as in the run's journal."""

    number: int
    """Number of the action in the run, from 1."""
    index: int
    """Index of the action in the network."""
    do: str
    source: str
    target: str
    parameters: Mapping[str, Any]
    start: float
    """The robot's time at the start of the action, in [s]; all times here are the robot's."""
    end: float
    """Time at the end of the action, in [s]; if the journal has no end, the time when the run broke off."""
    broken_off: float | None
    """Time when the motion was broken off and restoring began, in [s]; None if it was not."""
    outcome: str
    """Success, Fail or GiveUp; empty if the journal does not contain it."""
    result: Record = field(default_factory=dict)
    """Record of its end in the journal."""

    @property
    def reason(self) -> str:
        """Reason why the action did not succeed; empty for a Success."""
        return str(self.result.get("reason", ""))

    @property
    def cause(self) -> str:
        """Kind of cause of the action's Fail or GiveUp; empty in journals of older versions, which do not
        record causes.
        """
        found = self.result.get("cause") or [{}]
        return str(found[0].get("kind", ""))

    @property
    def fails(self) -> bool:
        """True if the action ended in Fail or GiveUp."""
        return self.outcome in ("Fail", "GiveUp")


@dataclass(frozen=True)
class PastRun:
    """A run as recorded in the journal of its folder, with its records, actions and network."""

    folder: Path
    header: Record
    records: Sequence[Record]
    actions: tuple[PastAction, ...]
    network: JournaledNetwork | None
    """Network of the run; None in journals of older versions."""
    torn_at: int | None
    """Offset of an incomplete last record, in [bytes]; None: all are complete."""

    @property
    def end(self) -> Record | None:
        """Record of the run's end; None for a run that was killed or is still running."""
        last = next(record for record in reversed(self.records) if record["kind"] in ("END", "EPOCH", "RUN"))
        return last if last["kind"] == "END" else None

    @cached_property
    def track(self) -> RunTrack | None:
        """The robot's pose in each period; None if the run did not save its poses.

        Raises:
            NoRun: the file of the poses cannot be read.
        """
        content = read_file(self.folder, TELEMETRY_FILE, MAX_TELEMETRY, missing=True)
        if content is None:
            return None
        try:
            return load_track(BytesIO(content))
        except (LookupError, ValueError, OSError, BadZipFile) as error:
            raise NoRun(self.folder, f"{TELEMETRY_FILE} in it is not a track ({error})") from None

    @property
    def last_fail(self) -> PastAction | None:
        """The last action that ended in Fail or GiveUp; None without one."""
        return next((action for action in reversed(self.actions) if action.fails), None)

    def before(self, action: PastAction) -> Iterator[Record]:
        """Yield the journal's records before the record START of an action, in the journal's order."""
        for record in self.records:
            if record["kind"] == "START" and record["n"] == action.number:
                return
            yield record


def read_run(folder: Path | str) -> PastRun:
    """Read a run's journal.

    Args:
        folder: the run's folder.

    Raises:
        NoRun: the journal is missing or of another format, or an entry of the folder is not a plain file.
        JournalError: a record before the last one is damaged, or a record is inconsistent.
    """
    folder = Path(folder)
    contents = read_run_journal(folder)
    if not contents.records:
        raise NoRun(folder, f"{JOURNAL_FILE} holds no whole record")
    header = contents.records[0]
    if header["kind"] != "RUN" or header.get("schema") != JOURNAL_SCHEMA:
        said = header.get("schema", header["kind"])
        raise NoRun(folder, f"{JOURNAL_FILE} is not of the format {JOURNAL_SCHEMA}, but of {said!r}")
    record: Record = header
    try:
        kept = header.get("plan_on")
        network = None if kept is None else network_of(kept)
        actions = []
        for record in contents.records:
            if record["kind"] == "START":
                action = _action(record, contents.records)
                _check_action(action, network)
                actions.append(action)
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        wrong = f"record {record['q']} ({record['kind']}) makes no sense: {type(error).__name__}: {error}"
        raise JournalError(folder / JOURNAL_FILE, wrong) from None
    return PastRun(folder, header, contents.records, tuple(actions), network, contents.torn_at)


def _check_action(action: PastAction, kept: JournaledNetwork | None) -> None:
    if kept is None:
        return
    there = kept.network.actions
    known = there[action.index] if 0 <= action.index < len(there) else None
    if known is None or (known.do, known.source, known.target) != (action.do, action.source, action.target):
        said = f"{action.do} from {action.source} to {action.target}"
        raise ValueError(f"the journal's network has no such action {action.index}: {said}")


def _action(start: Record, records: Sequence[Record]) -> PastAction:
    number, words = int(start["n"]), start["action"]
    ends = [record for record in records if record.get("n") == number]
    result = next((record for record in ends if record["kind"] == "RESULT"), {})
    restore = next((record for record in ends if record["kind"] == "RESTORE"), None)
    after = [record for record in records if record["kind"] == "EPOCH" and record["q"] > start["q"]]
    last = after[0] if after else records[-1]
    return PastAction(
        number,
        int(words["index"]),
        str(words["do"]),
        str(words["from"]),
        str(words["to"]),
        words["with"],
        float(start["t"]),
        float(result.get("t", last["t"])),
        None if restore is None else float(restore["t"]),
        str(result.get("outcome", "")),
        result,
    )
