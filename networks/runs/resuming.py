"""A run that broke off: its known state, and its resume."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.backends.capabilities.arm import Arm
from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import NoWay
from handcart.networks.journal.journal import JOURNAL_SCHEMA, check_not_alive
from handcart.networks.journal.journal_record import JournalContents
from handcart.networks.journal.retracing import NeedsOperator, RunPosition, standing
from handcart.networks.journal.waiting import may_have_begun
from handcart.networks.run_files.run_folder import JOURNAL_FILE, read_run_journal

from .checkpoint import CHECKPOINT_FILE, Checkpoint, load_checkpoint
from .run_header import is_of_network

if TYPE_CHECKING:
    from handcart.backends.robot.robot import Robot

_NEEDED = {
    *("schema", "handcart", "task_path", "settings", "network", "backend", "bench", "seed", "errors"),
    *("robot", "robot_sha256", "start", "simulated"),
}
"""Header fields that are needed to resume a run."""
_DOUBTFUL = {"INTENT": "effect", "PNR": "what"}
"""Kinds of records after which it is unknown what happened, with the field that describes the effect."""


class NothingToResume(InputError):
    """Error: the run has ended, so there is nothing to resume."""


@dataclass(frozen=True)
class Past:
    """Content of an interrupted run's folder, read once: journal, checkpoint, and state of the run."""

    folder: Path
    contents: JournalContents
    standing: RunPosition
    checkpoint: Checkpoint | None
    recovered: Mapping[str, Any] | None
    """The RESULT that the checkpoint holds and the journal lacks, by a crash in between; None without one."""
    closing: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    """Records that the check of a real robot adds to the journal."""

    @property
    def last(self) -> int:
        """Number of the last complete record in the journal of the run that is to be resumed."""
        return len(self.contents.records) - 1

    @property
    def time_s(self) -> float:
        """The robot's time of the journal's last complete record, in [s]."""
        return float(self.contents.records[-1]["t"])

    @property
    def resume_records(self) -> list[tuple[str, Mapping[str, Any], Mapping[str, Any]]]:
        """Records to append to the journal before the run continues.

        Each has its kind, its fields, and those fields that are not part of the checksum (under the key
        `wall`).
        """
        records: list[tuple[str, Mapping[str, Any], Mapping[str, Any]]] = []
        if self.recovered is not None and self.checkpoint is not None:
            wall = {"checkpoint": self.checkpoint.digest}
            records.append(("RESULT", {**self.recovered, "recovered": True}, wall))
        records += [(kind, fields, {}) for kind, fields in self.closing]
        doubt = self.standing.in_doubt
        epoch = {"after": self.last, "in_doubt": None if doubt is None else doubt["n"]}
        return [*records, ("EPOCH", epoch, {})]

    def doubts(self) -> Iterator[str]:
        """Yield descriptions of facts that are unknown after an interruption, such as whether an effect of
        the interrupted action has happened.
        """
        doubt = self.standing.in_doubt
        if doubt is None:
            return
        what = doubt["action"]
        yield f"how far action {doubt['n']}, {what['do']} from {what['from']}, had come"
        for record in self.contents.records[doubt["q"] :]:
            if record["kind"] in _DOUBTFUL:
                yield f"whether it happened: {record[_DOUBTFUL[record['kind']]]}"
        if self.contents.torn_at is not None:
            yield f"the content of record {self.last + 1}, which is damaged"

    def words(self, now_s: float, boot: str | None) -> list[str]:
        """Return lines of text on the run's last known state, as information before it is resumed.

        They also mention an incomplete end of the journal, the result of the last action if it was recovered
        from the checkpoint, and a restart of the computer.

        Args:
            now_s: the wall clock, in [s] since 1970.
            boot: the computer's present boot ID, which shows whether it was restarted; None if unknown.
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
            lines.append("known: the machine was restarted since")
        return lines

    def check_robot(self, robot: Robot) -> None:
        """Raise `NeedsOperator` if the journal of the run to resume describes a robot with another number of
        joints than `robot`.
        """
        arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
        joints = 0 if arm is None else arm.command().size
        for at in (self.standing.at, *self.standing.seen.values()):
            if at is not None and (at.joints.size, at.joint_command.size) != (joints, joints):
                wrong = (
                    f"{self.folder / JOURNAL_FILE} describes {at.joints.size} joints, "
                    f"and the robot has {joints}"
                )
                raise NeedsOperator(printable(wrong))

    def next_words(self) -> str:
        """Return a line of text on the action that a resumed run starts next, or why none is next."""
        route = self.standing.route
        if route.arrived:
            return f"next: {'another round' if route.has_next_round else 'nothing, the goal is reached'}"
        plan = route.planner.plan(route.situation, None if route.goal == route.network.goal else route.goal)
        return f"next: {plan.explanation if isinstance(plan, NoWay) else plan.actions[0]}"


def read_past(folder: Path, network: ActionNetwork) -> Past:
    """Read the state of the run in a folder.

    Raises:
        NoRun: the folder is not that of a run.
        JournalError: the journal cannot be read, or a record before its last one is damaged.
        NotAState: the checkpoint is not valid.
        NeedsOperator: the journal does not fit the task, the checkpoint does not belong to the journal, or
            the run ended in a GiveUp that was not acknowledged.
    """
    contents = read_run_journal(folder)
    here = standing(network, contents.records, is_of_network)
    if here.gave_up is not None:
        record = here.gave_up
        how = f"when all is as it was before that action: handcart ack {folder} {record['q']}"
        raise NeedsOperator(f"the run gave up: {record['reason']}; {how}")
    if contents.torn_at is not None and here.in_doubt is None:
        here.in_doubt = _maybe_begun(here, contents)
    checkpoint = load_checkpoint(folder)
    recovered = None
    if checkpoint is not None and checkpoint.digest != _named(contents):
        recovered = _recovered(folder, checkpoint, here, contents)
        here.followed([{"kind": "RESULT", "q": len(contents.records), **recovered}])
    return Past(folder, contents, here, checkpoint, recovered)


def _named(contents: JournalContents) -> str | None:
    """Return the checkpoint that belongs to the last result, by its digest."""
    results = (record for record in reversed(contents.records) if record["kind"] == "RESULT")
    kept = (result for result in results if result["outcome"] != "GiveUp" and result.get("by") != "recon")
    last = next(kept, None)
    return None if last is None else last["wall"].get("checkpoint")


def _recovered(
    folder: Path, checkpoint: Checkpoint, here: RunPosition, contents: JournalContents
) -> Mapping[str, Any]:
    """Return the result of the action in doubt: its checkpoint was kept, and a crash came before the journal
    had it.

    Raises:
        NeedsOperator: the checkpoint is not the one of that action.
    """
    doubt = here.in_doubt
    whole = doubt is not None and checkpoint.after == contents.records[-1]["h"]
    if doubt is None or not whole or checkpoint.result["n"] != doubt["n"]:
        difference = (
            f"it is of action {checkpoint.result['n']}, and the journal's last result of action {here.done}"
        )
        words = f"the checkpoint in {folder} is not the one that its journal names: {difference}"
        if not contents.records[0].get("simulated", True):
            words += f"; if the robot may continue without its learned facts: rm {folder / CHECKPOINT_FILE}"
        raise NeedsOperator(words)
    return checkpoint.result


def _maybe_begun(here: RunPosition, contents: JournalContents) -> Mapping[str, Any] | None:
    """Return the START that a damaged last record may have been (row D3)."""
    route = here.route
    if not route.planned or not may_have_begun(contents.records):
        return None
    action = route.next
    words = {"index": action.index, "do": action.do, "from": action.source, "to": action.target}
    return {"kind": "START", "q": len(contents.records), "n": here.started + 1, "action": words}


def task_of(folder: Path) -> Mapping[str, Any]:
    """Return the header of a run's journal, with task, settings, backend and seed, to resume the run.

    Raises:
        NoRun: the folder is not that of a run.
        JournalError: the journal cannot be read, or a record before its last one is damaged.
        RunAlive: the run is still running.
        NothingToResume: the run ended in Success or Fail.
        NeedsOperator: the journal names no task, or another version of handcart has written it (row D12 of
            faults.md).
    """
    records = read_run_journal(folder).records
    check_not_alive(folder)
    if not records or not records[0].keys() >= _NEEDED:
        raise NeedsOperator(f"{folder / JOURNAL_FILE} doesn't name the task that was run")
    header = records[0]
    for what, said, ours in (
        ("journal is of the format", header["schema"], JOURNAL_SCHEMA),
        ("run is one of handcart", header["handcart"], version("handcart")),
    ):
        if said != ours:
            raise NeedsOperator(printable(f"the {what} {said[:40]!r}; only {ours!r} can continue it here"))
    last = next(record for record in reversed(records) if record["kind"] in ("END", "EPOCH", "RUN"))
    if last["kind"] == "END" and last["outcome"] in ("Success", "Fail"):
        words = f"the run in {folder} is over: {last['outcome']} in situation {last['situation']}"
        raise NothingToResume(printable(f"{words}; allowed: one that broke off, was stopped or gave up"))
    return header


def _wall(record: Mapping[str, Any]) -> Mapping[str, Any]:
    wall: Mapping[str, Any] = record["wall"]
    return wall
