"""From a journal's records to where its run stands in the network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from files.errors import HandcartError
from primitives.outcome import Success

from .network import ActionNetwork
from .route import Route

Record = Mapping[str, Any]


class NeedsOperator(HandcartError):
    """A run can't go on before a person has decided something. Exit status 6."""

    exit_status = 6


@dataclass
class Standing:
    """Where a run stands, by its journal alone."""

    route: Route
    started: int = 0
    fails: int = 0
    plans: int = 0
    skipped: list[str] = field(default_factory=list)
    in_doubt: Record | None = None
    """The START of an action of which nobody knows how far it came."""
    gave_up: Record | None = None
    """The RESULT of a GiveUp that nobody has acknowledged."""
    over: Record | None = None
    """The END of a run that came to its end."""
    done: int = 0
    """Number of the last action with a RESULT."""
    left: str = ""
    """The situation in which that action began."""


def standing(network: ActionNetwork, records: Sequence[Record]) -> Standing:
    """Follow a journal through the network that it was written for.

    Raises:
        NeedsOperator: the journal is of another network, or doesn't fit this one.
    """
    if not records or records[0].get("network") != network.fingerprint():
        raise NeedsOperator("the task is not the one that was run: its network is another one")
    found = Standing(Route(network))
    for record in records[1:]:
        try:
            _follow(found, record)
        except (KeyError, IndexError) as error:
            words = f"record {record['q']} ({record['kind']}) doesn't fit the task's network"
            raise NeedsOperator(f"{words}: {error!r}") from None
    return found


def _follow(found: Standing, record: Record) -> None:
    route, kind = found.route, record["kind"]
    if kind == "PLAN":
        found.plans += 1
        route.plan()
    elif kind == "START":
        found.started, found.in_doubt = record["n"], record
    elif kind == "RESULT":
        found.in_doubt, found.done, found.left = None, record["n"], route.situation
        _take(found, record)
    elif kind == "NOT_STARTED":
        found.fails += 1
        route.failed(record["reason"])
    elif kind == "SKIP":
        found.skipped.append(record["element"])
        route.took(Success({}))
    elif kind == "END":
        found.over = record
    elif kind == "ACK":
        found.gave_up, found.over = None, None
        found.fails += 1
        route.failed(record["reason"])
    elif kind == "EPOCH":
        found.in_doubt, found.over = None, None


def _take(found: Standing, record: Record) -> None:
    if record["outcome"] == "Success":
        found.route.took(Success({}))
    elif record["outcome"] == "Fail":
        found.fails += 1
        found.route.failed(record["reason"], record["permanent"])
    else:
        found.gave_up = record
