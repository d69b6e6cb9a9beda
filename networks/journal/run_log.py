"""Log of a run: first into the journal, then to the observers."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from handcart.backends.robot.robot import Robot
from handcart.networks.events.events import (
    AimChanged,
    Ended,
    Event,
    LeftOut,
    Planned,
    Restoring,
    RunEnded,
    Started,
)
from handcart.networks.events.run_end import RunEnd
from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import NoWay, Plan
from handcart.networks.graph.route import NotStarted
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.intents import Intents
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes.cause import Cause
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome, Success
from handcart.primitives.restoring.snapshot import Snapshot

from . import run_records as records
from .journal import Journal
from .measured import measured_fields
from .retracing import RunPosition

Keep = Callable[[Mapping[str, Any], str], str | None]
"""Function that keeps a checkpoint and returns its digest, None if none is kept.

It is called with an action's result, before the journal has it, and the checksum of the last record.
"""


_NOTHING: Mapping[str, Any] = {}


class RunLog(Intents):
    """Log of a run's events, which counts them, writes them to the journal and notifies observers."""

    def __init__(
        self,
        robot: Robot,
        model: WorldModel,
        journal: Journal | None,
        observers: Sequence[Callable[[Event], None]],
        standing: RunPosition | None = None,
        keep: Keep | None = None,
    ) -> None:
        self.started = standing.started if standing else 0
        self.fails = standing.fails if standing else 0
        self.plans = standing.plans if standing else 0
        self.skipped: list[str] = list(standing.skipped) if standing else []
        self.open = False
        """True while an action has started whose outcome is not yet safely in the journal."""
        self._keep = keep
        self._robot = robot
        self._model = model
        self._journal = journal
        self._observers = observers
        self._said: dict[int, records.ActionWords] = {}
        self._changes: Mapping[str, Any] = {}

    def planned(self, situation: str, plan: Plan | NoWay) -> None:
        """Log that a plan was made, or that no plan was found."""
        self.plans += 1
        record = records.PlannedRecord(situation=situation)
        if isinstance(plan, Plan):
            record["way"], record["cost"] = [action.index for action in plan.actions], plan.cost
            record["excluded"] = [item.index for item in plan.excluded]
        else:
            record["no_way"] = plan.explanation
            record["excluded"] = [action_.index for action_ in plan.blocking]
        if plan.judged is not None:
            record["judged"] = plan.judged.fields()
        self._write("PLAN", record)
        self._tell(lambda: Planned(self._robot.time, situation, plan))

    def not_planned(self, situation: str, error: Exception) -> None:
        """Log that a plan could not be made, because of a fault."""
        trace = "".join(traceback.format_exception(error))
        self._write("PLAN", records.PlannedRecord(situation=situation, error=trace))

    def start(
        self, action: Action, primitive: ActionPrimitive, fails: int, at: Snapshot | None = None
    ) -> None:
        """Log that an action, with `fails` Fails so far, is about to start; `at` is a measured snapshot."""
        self.started += 1
        self.open = True
        if self._journal is not None:
            record: records.StartRecord = {"n": self.started, "action": self._words(action, primitive)}
            if at is not None:
                record["at"] = measured_fields(at)
            self._journal.append("START", self._robot.time, record)
        if self._observers:
            self._tell(lambda: Started(self._robot.time, self.started, action, primitive, fails))

    def intends(self, effect: str) -> None:
        """Log that the running action is about to do something that cannot simply be repeated."""
        self._write("INTENT", records.Intent(n=self.started, effect=effect))

    def passed(self, what: str) -> None:
        """Log that the running action can no longer be undone, because of the effect described by `what`."""
        self._write("PNR", records.PointOfNoReturn(n=self.started, what=what))

    @property
    def kept(self) -> bool:
        """True if all records are on the disk, as far as the journal's `sync` demands it.

        Raises:
            JournalError: the records cannot be brought to the disk.
        """
        return self._journal is None or self._journal.durable

    def restoring(self, action: Action, reason: str) -> None:
        """Log that the running action begins to restore the state that it found at its start."""
        self._write("RESTORE", records.Restore(n=self.started, reason=reason))
        self._tell(lambda: Restoring(self._robot.time, action, reason))

    def result(self, primitive: ActionPrimitive, outcome: Outcome, at: Snapshot | None = None) -> None:
        """Log that an action has ended, after writing a checkpoint of the run if checkpoints are kept.

        Observers are not notified by this method, but later by `result_kept`.

        Args:
            primitive: primitive of the action, with its evidence.
            outcome: outcome of the action.
            at: snapshot of the robot; None if none was measured.
        """
        self._changes = changes = self._model.taken_changes()
        if self._journal is None and self._keep is None:
            return
        record = outcome_record(self.started, outcome)
        if changes:
            record["learned"] = changes
        if not isinstance(outcome, Success):
            _add_causes(record, primitive.evidence, outcome.residuals.limits)
        if at is not None:
            record["at"] = measured_fields(at)
        wall = _NOTHING
        if self._keep is not None:
            kept = self._keep(record, "" if self._journal is None else self._journal.last)
            # Outside the chain: a physics engine's state is not the same bytes in two runs of one seed.
            wall = _NOTHING if kept is None else {"checkpoint": kept}
        if self._journal is not None:
            # Nothing is acted on before the next record, such as START or END.
            self._journal.append("RESULT", self._robot.time, record, wall, True)

    def result_kept(self, action: Action, primitive: ActionPrimitive, outcome: Outcome) -> None:
        """Notify the observers of a result that is safely in the journal."""
        self.open = False
        self.result_told(action, primitive, outcome)

    def result_told(self, action: Action, primitive: ActionPrimitive, outcome: Outcome) -> None:
        """Notify the observers of a result in the journal, which may not be on the disk yet."""
        if self._observers:
            changes = self._changes
            self._tell(lambda: Ended(self._robot.time, self.started, action, primitive, outcome, changes))

    def stopped(self, cause: str, asked: float) -> None:
        """Log that the robot was commanded to stop just now.

        Args:
            cause: cause of the stop.
            asked: time of the request to stop, in [s] of the robot's time.
        """
        sent = round(self._robot.time, 6)
        self._write("STOP", records.StopRecord(cause=cause, asked_s=round(asked, 6), sent_s=sent))

    def world_changed(
        self, action: Action, stood: Snapshot, now: Snapshot, situation: str | None, reason: str
    ) -> None:
        """Log that the world was changed between two actions, so that the next one is not started.

        Args:
            action: the action that is not started.
            stood: snapshot after the last action.
            now: present snapshot, before `action`.
            situation: the situation that holds now; None if that could not be decided.
            reason: reason in words.
        """
        record = records.Recon(
            action=action.index,
            reason=reason,
            situation=situation,
            expected=measured_fields(stood),
            at=measured_fields(now),
        )
        self._write("RECON", record)
        self._tell(lambda: LeftOut(self._robot.time, action, reason))

    def not_started(self, action: Action, reason: str, cause: str) -> NotStarted:
        """Log that an action could not be started, and return a `NotStarted` with the reason as the action's
        result. `cause` is the name of the cause's kind.
        """
        self.open = False
        record = records.NotStartedRecord(action=action.index, reason=reason, cause=cause)
        self._write("NOT_STARTED", record)
        self._tell(lambda: LeftOut(self._robot.time, action, reason))
        return NotStarted(reason, cause=cause)

    def skip(self, action: Action, element: str) -> None:
        """Log that one element of a `repeat` is skipped: no further actions are done for it."""
        self.skipped.append(element)
        self._write("SKIP", records.Skip(action=action.index, element=element))
        self._tell(lambda: LeftOut(self._robot.time, action, f"{element} is left undone"))

    def aims_at(self, words: str, record: records.Aim) -> None:
        """Log that the run pursues another goal, by the journal's `record`; `words` describe the goal for
        people.
        """
        self._write("AIM", record)
        self._tell(lambda: AimChanged(self._robot.time, words))

    def ended(self, end: RunEnd, at: Snapshot | None = None) -> None:
        """Log the end of the run; `at` is a snapshot of the robot."""
        record = records.EndRecord(outcome=end.outcome, situation=end.situation, reason=end.reason)
        if at is not None:
            record["at"] = measured_fields(at)
        self._write("END", record)
        self._tell(lambda: RunEnded(self._robot.time, end))

    def _words(self, action: Action, primitive: ActionPrimitive) -> records.ActionWords:
        """Return the journal's fields of an action; made only once if nothing in them changes."""
        if action.index in self._said:
            return self._said[action.index]
        words: records.ActionWords = {
            "index": action.index,
            "do": action.do,
            "from": action.source,
            "to": action.target,
            "with": primitive.__pydantic_serializer__.to_python(primitive, mode="json"),
        }
        if action.binding is None or not action.binding.late:
            self._said[action.index] = words
        return words

    def _write(self, kind: str, fields: Mapping[str, object]) -> None:
        if self._journal is not None:
            self._journal.append(kind, self._robot.time, fields)

    def _tell(self, event: Callable[[], Event]) -> None:
        if self._observers:
            made = event()
            for observer in self._observers:
                observer(made)


def outcome_record(number: int, outcome: Outcome) -> records.Result:
    """Return the fields of the journal's record of an outcome.

    Args:
        number: number of the action in the run, from 1.
        outcome: outcome of the action.
    """
    if isinstance(outcome, Success):  # by far the most frequent: a pattern takes longer
        succeeded: records.Succeeded = {"n": number, "outcome": "Success"}
        if outcome.result:
            succeeded["result"] = outcome.result
        if outcome.evidence:
            succeeded["evidence"] = dict(outcome.evidence)
        return succeeded
    match outcome:
        case Fail(reason, permanent, residuals):
            return records.Failed(
                n=number, outcome="Fail", reason=reason, permanent=permanent, residuals=dict(residuals)
            )
        case GiveUp(reason, residuals):
            return records.GivenUp(n=number, outcome="GiveUp", reason=reason, residuals=dict(residuals))


def _add_causes(record: records.Result, evidence: Evidence, limits: records.Sizes) -> None:
    """Add the causes for which an attempt didn't succeed to its record."""
    if evidence.causes:
        record["cause"] = [_cause(cause) for cause in evidence.causes]
    if limits:
        record["tolerance"] = limits
    if evidence.decisive:
        record["picture"] = evidence.decisive
    if evidence.facts:
        record["evidence"] = dict(evidence.facts)


def _cause(cause: Cause) -> records.CauseWords:
    words = records.CauseWords(
        reason=cause.reason, kind=cause.kind.name, check=cause.check, calls=list(cause.calls)
    )
    if cause.measured is not None:
        words["measured"] = cause.measured._asdict()
    if cause.fault:
        words["fault"] = cause.fault
    if cause.restoring:
        words["restoring"] = True
    return words
