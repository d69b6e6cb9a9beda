"""A run that is over (or broke off), read back from its folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

from handcart.networks.graph.journaled_network import JournaledNetwork, network_of
from handcart.networks.runs.run_folder import JOURNAL, read_file, read_run_journal
from handcart.networks.runs.run_folder import NoRun as NoRun
from handcart.networks.runs.telemetry import Track, load_track

from .journal import SCHEMA
from .journal_record import JournalError

TELEMETRY = "telemetry.npz"
MAX_TELEMETRY = 256 * 2**20
Record = Mapping[str, Any]


@dataclass(frozen=True)
class PastAction:
    """An action that was started."""

    number: int
    """Which one of the run, from 1."""
    index: int
    """In the network."""
    do: str
    source: str
    target: str
    parameters: Mapping[str, Any]
    start: float
    """[s] of the robot's time, as are the others."""
    end: float
    """Where it has none in the journal, when the run broke off."""
    broken_off: float | None
    """When the motion was broken off and restoring began."""
    outcome: str
    """Success, Fail or GiveUp; empty where the journal doesn't tell."""
    result: Record = field(default_factory=dict)
    """The journal's record of how it ended."""

    @property
    def reason(self) -> str:
        """Why it didn't succeed."""
        return str(self.result.get("reason", ""))

    @property
    def fails(self) -> bool:
        """Whether it ended in Fail or GiveUp."""
        return self.outcome in ("Fail", "GiveUp")


@dataclass(frozen=True)
class PastRun:
    """What a run's journal tells."""

    folder: Path
    header: Record
    records: Sequence[Record]
    actions: tuple[PastAction, ...]
    network: JournaledNetwork | None
    """None in the journals of older versions."""
    torn_at: int | None
    """Offset in [bytes] from which on the journal's tail is no whole record."""

    @property
    def end(self) -> Record | None:
        """The record of the run's end; None where it was killed, or still goes on."""
        last = next(record for record in reversed(self.records) if record["kind"] in ("END", "EPOCH", "RUN"))
        return last if last["kind"] == "END" else None

    @cached_property
    def track(self) -> Track | None:
        """Where the robot was, period by period; None where that wasn't kept.

        Raises:
            NoRun: the file holds something else.
        """
        content = read_file(self.folder, TELEMETRY, MAX_TELEMETRY, missing=True)
        if content is None:
            return None
        try:
            return load_track(BytesIO(content))
        except (LookupError, ValueError, OSError, BadZipFile) as error:
            raise NoRun(self.folder, f"{TELEMETRY} in it is no track ({error})") from None

    @property
    def last_fail(self) -> PastAction | None:
        """The last action that ended in Fail or GiveUp."""
        return next((each for each in reversed(self.actions) if each.fails), None)

    def before(self, action: PastAction) -> Iterator[Record]:
        """The records up to the action's START, that excluded."""
        for record in self.records:
            if record["kind"] == "START" and record["n"] == action.number:
                return
            yield record


def read_run(folder: Path | str) -> PastRun:
    """Read a run's journal.

    Args:
        folder: the run's folder.

    Raises:
        NoRun: there is no journal that says what was run, or something in the folder is no plain file.
        JournalError: it is damaged inside, or what it says makes no sense.
    """
    folder = Path(folder)
    contents = read_run_journal(folder)
    if not contents.records:
        raise NoRun(folder, f"{JOURNAL} holds no whole record")
    header = contents.records[0]
    if header["kind"] != "RUN" or header.get("schema") != SCHEMA:
        said = header.get("schema", header["kind"])
        raise NoRun(folder, f"{JOURNAL} is no journal of the format {SCHEMA}, but {said!r}")
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
        raise JournalError(folder / JOURNAL, wrong) from None
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
