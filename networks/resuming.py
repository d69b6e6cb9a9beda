"""A run that broke off: what is known of it, and how it goes on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .checkpoint import Checkpoint, load_checkpoint
from .journal_record import JournalContents, read_journal
from .network import ActionNetwork
from .planner import NoWay
from .retracing import NeedsOperator, Standing, standing
from .waiting import broken_off

if TYPE_CHECKING:
    from .recon import Recon

JOURNAL = "journal.jsonl"
_DOUBTFUL = {"INTENT": "effect", "PNR": "what"}
"""Records that leave unknown what has happened, and where they tell it."""


@dataclass(frozen=True)
class Past:
    """What a run's folder holds, read once."""

    folder: Path
    contents: JournalContents
    standing: Standing
    checkpoint: Checkpoint | None
    recovered: Mapping[str, Any] | None
    """The RESULT that the checkpoint holds and the journal lacks: a crash came in between."""
    closing: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    """What a look at a real robot adds to the journal."""

    @property
    def last(self) -> int:
        """Number of the journal's last whole record."""
        return len(self.contents.records) - 1

    @property
    def time_s(self) -> float:
        """The robot's time of that record, in [s]."""
        return float(self.contents.records[-1]["t"])

    @property
    def to_tell(self) -> list[tuple[str, Mapping[str, Any]]]:
        """Records that the journal gets before the run goes on."""
        records: list[tuple[str, Mapping[str, Any]]] = []
        if self.recovered is not None:
            records.append(("RESULT", {**self.recovered, "recovered": True}))
        records += self.closing
        doubt = self.standing.in_doubt
        records.append(("EPOCH", {"after": self.last, "in_doubt": None if doubt is None else doubt["n"]}))
        return records

    def doubts(self) -> Iterator[str]:
        """What may have happened since the last that is known."""
        doubt = self.standing.in_doubt
        if doubt is None:
            return
        what = doubt["action"]
        yield f"how far action {doubt['n']}, {what['do']} from {what['from']}, had come"
        for record in self.contents.records[doubt["q"] :]:
            if record["kind"] in _DOUBTFUL:
                yield f"whether it happened: {record[_DOUBTFUL[record['kind']]]}"

    def words(self, now_s: float, boot: str | None) -> list[str]:
        """What is known and recovered, and what would come next, a line each.

        Args:
            now_s: the wall clock, in [s] since 1970.
            boot: the machine's boot ID now.
        """
        here, wall = self.standing, self.contents.records[-1]["wall"]
        age = f"{max(0.0, now_s - wall['unix_s']):.0f} s ago"
        lines = [
            f"known: record {self.last}, {age}; situation {here.route.situation}, {here.started} actions "
            f"started, {here.fails} failed"
        ]
        if self.contents.torn_at is not None:
            lines.append(f"torn: the journal's tail from byte {self.contents.torn_at} on is set aside")
        if self.recovered is not None:
            ended = f"action {self.recovered['n']} had ended with {self.recovered['outcome']}"
            lines.append(f"recovered: {ended}")
        before = next(
            (w["boot_id"] for w in map(_wall, reversed(self.contents.records)) if "boot_id" in w), boot
        )
        if before != boot:
            lines.append("known: the machine was started anew since")
        return lines

    def next_words(self) -> str:
        """What would be done next."""
        route = self.standing.route
        if route.arrived:
            return "next: nothing, the goal is reached"
        plan = route.planner.plan(route.situation)
        return f"next: {plan.explanation if isinstance(plan, NoWay) else plan.actions[0]}"

    def after_look(self, recon: Recon, confirm: int | None) -> Past:
        """The same, to go on from what a look at a real robot found; an action in doubt counts as failed.

        Args:
            recon: what was found.
            confirm: the journal's last record, as a person has seen it.

        Raises:
            NeedsOperator: the robot isn't as it was left, nobody can tell, or nobody has confirmed.
        """
        doubt = self.standing.in_doubt
        if recon.off:
            where = "where that action began" if doubt else "where it was left"
            off = ", ".join(f"{name} {size:.3g}" for name, size in recon.off.items())
            raise NeedsOperator(f"the robot isn't {where}: {off}; bring it there, then resume again")
        if doubt is not None and (not recon.sure or len(list(self.doubts())) > 1):
            how = f"if all is as it was before that action: handcart ack {self.folder} {doubt['q']}"
            raise NeedsOperator(f"{broken_off(doubt)}, and no sensor tells what it did; {how}")
        if confirm != self.last:
            how = f"handcart resume {self.folder} --confirm {self.last}"
            raise NeedsOperator(f"a real robot moves only after a look at it: {how}")
        closing: list[tuple[str, Mapping[str, Any]]] = [("RECON", recon.fields())]
        if doubt is not None:
            fail = {"n": doubt["n"], "outcome": "Fail", "reason": broken_off(doubt), "permanent": False}
            found = {"residuals": recon.residuals, "tolerance": recon.limits, "by": "recon"}
            closing.append(("RESULT", fail | found))
        records = [{"kind": kind, "q": -1, **fields} for kind, fields in closing]
        return replace(self, standing=self.standing.followed(records), closing=tuple(closing))


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
        here.followed([{"kind": "RESULT", "q": len(contents.records), **recovered}])
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


def _wall(record: Mapping[str, Any]) -> Mapping[str, Any]:
    wall: Mapping[str, Any] = record["wall"]
    return wall
