"""Retracing of a run's position in the network from its journal's records."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from handcart.files.errors import HandcartError
from handcart.files.printable import printable
from handcart.networks.deciding.planners import planner_of
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.route import Elsewhere, RunDecisions
from handcart.primitives.outcomes.causes import PREEMPTED
from handcart.primitives.outcomes.outcome import Success
from handcart.primitives.restoring.snapshot import Snapshot

from .measured import snapshot_of

TORN_RECORD = "TORN"
"""Name of a damaged last record in an ACK."""
_OF_ONE = ("INTENT", "PNR", "RESTORE", "RESULT")
_OF_ROUND = ("PLAN", "START", "NOT_STARTED", "SKIP")
"""Kinds of records that a round has only after it has begun, unless they belong to an interrupt."""
Record = Mapping[str, Any]


class NeedsOperator(HandcartError):
    """Error, because a person has to check or acknowledge something before a run is resumed.

    The exit status is 6.
    """

    exit_status = 6


@dataclass
class RunPosition:
    """State of a run after the records of its journal (situation, counts of Fails, open records), from which
    it can be resumed.
    """

    route: RunDecisions
    started: int = 0
    fails: int = 0
    cause: str = ""
    """Kind of cause of the last action that did not succeed; empty if unknown, or without one."""
    plans: int = 0
    skipped: list[str] = field(default_factory=list)
    in_doubt: Record | None = None
    """START record of an action of unknown progress; None without one."""
    gave_up: Record | None = None
    """Record of a GiveUp that was not acknowledged: a RESULT, or an END between actions; None without one."""
    over: Record | None = None
    """END record of a run that came to its end; None for one that may continue."""
    done: int = 0
    """Number of the last action with a RESULT."""
    left: str = ""
    """The situation in which the last action with a RESULT began."""
    at: Snapshot | None = None
    """Snapshot of the robot when the run last knew its situation; None if none was measured then."""
    round_began: float = 0.0
    """The robot's time at the begin of the round, in [s]; the expected time while the round waits."""
    round_waits: bool = False
    """True between the journal's record that the round waits and the round's first plan."""
    last_t: float = 0.0
    """The robot's time of the last record, in [s]."""
    interrupted: dict[int, float] = field(default_factory=dict)
    """Time of each interrupt's last occurrence, in [s], by its number."""
    charging: int | None = None
    """Number of the last interrupt that waits for the battery's charge, until the run leaves its goal."""
    seen: dict[str, Snapshot] = field(default_factory=dict)
    """Snapshots of the robot in earlier situations of the run, the last one at the end."""

    def followed(self, records: Sequence[Record]) -> RunPosition:
        """Update this state of a run by further records of its journal, and return it.

        Args:
            records: the further records, in order.

        Raises:
            NeedsOperator: a record does not fit the task's network.
        """
        for record in records:
            try:
                _follow(self, record)
            except (LookupError, TypeError, ValueError) as error:
                words = f"record {record['q']} ({record['kind']}) doesn't fit the task's network"
                raise NeedsOperator(printable(f"{words}: {error}")) from None
        return self


def has_fingerprint(header: Record, network: ActionNetwork) -> bool:
    """Return whether a journal was written for a network, whose checksum is in the journal's first record."""
    return bool(header.get("network") == network.fingerprint())


def standing(
    network: ActionNetwork,
    records: Sequence[Record],
    is_of: Callable[[Record, ActionNetwork], bool] = has_fingerprint,
) -> RunPosition:
    """Return where a run is in its network, and what it has tried, after all records of its journal.

    Args:
        network: the task's network.
        records: records of the journal.
        is_of: function that returns whether a journal's first record belongs to a network.

    Raises:
        NeedsOperator: the journal is of another network, or does not fit this one.
    """
    if not records or not is_of(records[0], network):
        raise NeedsOperator("the task is not the one that was run: its network is another one")
    return RunPosition(RunDecisions(network, planner_of(network))).followed(records[1:])


def _follow(found: RunPosition, record: Record) -> None:
    route, kind = found.route, record["kind"]
    _check(found, record)
    found.last_t = max(found.last_t, float(record.get("t", 0.0)))
    if found.round_waits and kind in _OF_ROUND and route.priority is None:  # not on behalf of an interrupt
        _round_begins(found, float(record["t"]))
    if kind == "PLAN":
        found.plans += 1
        route.plan()
    elif kind == "START":
        found.started, found.in_doubt = record["n"], record
        interrupts = route.network.aims.interrupts
        if found.charging is not None and route.situation in interrupts[found.charging].goals:
            found.charging = None
        if found.at is None:
            _stands(found, record)
    elif kind == "RESULT":
        found.in_doubt, found.done, found.left = None, record["n"], route.situation
        _take(found, record)
    elif kind == "NOT_STARTED":
        found.in_doubt = None
        _fail(found, record, record.get("cause", ""))
    elif kind == "RECON":
        _look(found, record)
    elif kind == "AIM":
        _aim(found, record)
    elif kind == "SKIP":
        found.skipped.append(record["element"])
        route.took(Success({}))
    elif kind == "END":
        found.over = record
        found.gave_up = found.gave_up or (record if record["outcome"] == "GiveUp" else None)
    elif kind == "ACK":
        _acknowledge(found, record)
    elif kind == "EPOCH":
        found.in_doubt, found.over = None, None
    if found.at is not None:
        found.seen.pop(route.situation, None)
        found.seen[route.situation] = found.at


def _check(found: RunPosition, record: Record) -> None:
    """Raise `ValueError` for a record that cannot follow those before it."""
    kind, route = record["kind"], found.route
    if "situation" in record and record["situation"] not in (None, *route.network.situations):
        raise ValueError(f"unknown situation {record['situation']!r}")
    if kind in ("PLAN", "AIM") and record["situation"] != route.situation:
        raise ValueError(f"the run is in situation {route.situation}")
    if kind in ("START", "NOT_STARTED", "SKIP", "RECON") and "action" in record:
        index = record["action"]["index"] if kind == "START" else record["action"]
        if not route.planned or route.next.index != index:
            raise ValueError("another action was next")
    if kind == "START" and record["n"] != found.started + 1:
        raise ValueError(f"action {found.started + 1} was next")
    if kind in _OF_ONE and (found.in_doubt is None or record["n"] != found.in_doubt["n"]):
        raise ValueError(f"action {record['n']} is not the one that was started")


def _round_begins(found: RunPosition, now: float) -> None:
    """Note that a round no longer waits; a clock may have come to its time of day earlier than expected."""
    found.round_waits, rounds = False, found.route.network.aims.rounds
    if rounds is not None and rounds.at:
        found.round_began = now


def _take(found: RunPosition, record: Record) -> None:
    cause = str((record.get("cause") or [{}])[0].get("kind", ""))
    if record["outcome"] == "GiveUp":
        found.gave_up, found.cause = record, cause
        return
    _stands(found, record)
    if record["outcome"] == "Success":
        found.route.took(Success({}, record.get("result", "")))
    elif record.get("stays"):
        found.fails, found.cause = found.fails + 1, cause
        found.route.acknowledged(record["reason"])
    else:
        _fail(found, record, cause)


def _fail(found: RunPosition, record: Record, cause: str) -> None:
    """Follow an action that failed or was not started; one that was preempted does not count."""
    if cause != PREEMPTED.name:
        found.fails, found.cause = found.fails + 1, cause
    found.route.failed(record["reason"], record.get("permanent", False), cause)


def _aim(found: RunPosition, record: Record) -> None:
    """Follow a change of what the run pursues."""
    route, what, now = found.route, record["what"], float(record["t"])
    if what == "abandon":
        route.abandon(record["reason"])
    elif what == "wait":
        found.round_waits, found.round_began = True, float(record.get("at_s", now))
    elif what == "round":
        route.begin_round()
        found.round_waits, found.round_began = True, float(record.get("at_s", now))
        if route.round != record["round"]:
            raise ValueError(f"round {route.round} was next")
    else:
        number, interrupts = record["interrupt"], route.network.aims.interrupts
        found.interrupted[number] = now
        if interrupts[number].battery_until is not None:
            found.charging = number
        if route.interrupt(number) != record.get("goal", ""):
            raise ValueError("the interrupt leads elsewhere")


def _look(found: RunPosition, record: Record) -> None:
    if record["situation"] is not None:
        found.fails, found.cause = found.fails + 1, ""
        found.route.took(Elsewhere(record["reason"], record["situation"]))
        _stands(found, record)


def _acknowledge(found: RunPosition, record: Record) -> None:
    found.gave_up, found.over = None, None
    if record["of"] == "END":  # an action that had begun then stays in doubt
        return
    found.in_doubt = None
    if record["of"] == TORN_RECORD and not found.route.planned:
        return
    found.fails += 1
    if record.get("stays"):
        found.route.acknowledged(record["reason"])
    else:  # of an older version, which followed `on_fail`: its later records begin there
        found.route.failed(record["reason"])


def _stands(found: RunPosition, record: Record) -> None:
    if "at" in record:
        found.at = snapshot_of(record["at"])
