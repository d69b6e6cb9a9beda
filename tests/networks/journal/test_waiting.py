"""Records of a journal that wait for a person."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.networks.journal.journal_record import JournalContents
from handcart.networks.journal.waiting import waiting

PLAN = {"kind": "PLAN"}
START = {"kind": "START", "n": 1, "action": {"do": "DRIVE", "from": "a"}}
INTENT = {"kind": "INTENT", "n": 1, "effect": "the lamp goes out"}
DONE = {"kind": "RESULT", "n": 1, "outcome": "Success"}
FAILED = {"kind": "RESULT", "n": 1, "outcome": "Fail", "reason": "blocked"}
STUCK = {"kind": "RESULT", "n": 1, "outcome": "GiveUp", "reason": "stuck"}
REFUSED = {"kind": "NOT_STARTED", "action": 0, "reason": "refused"}
LOST = {"kind": "END", "outcome": "GiveUp", "reason": "lost"}
EPOCH = {"kind": "EPOCH", "after": 3}
BROKEN_OFF = "action 1, DRIVE from a, was broken off"


def ack(number: int) -> dict[str, Any]:
    return {"kind": "ACK", "record": number}


def end(outcome: str) -> dict[str, Any]:
    return {"kind": "END", "outcome": outcome, "reason": "it"}


def found(*records: dict[str, Any], simulated: bool = False, torn: bool = False) -> dict[int, str]:
    """Return what waits after the first record, which is number 0, and these."""
    numbered = [
        {"q": q, **record} for q, record in enumerate([{"kind": "RUN", "simulated": simulated}, *records])
    ]
    return waiting(JournalContents(tuple(numbered), 999 if torn else None, 1000))


@pytest.mark.parametrize(
    ("records", "waits"),
    [
        ([PLAN], {}),
        ([PLAN, START], {2: BROKEN_OFF}),
        ([PLAN, START, INTENT], {2: BROKEN_OFF}),
        ([PLAN, START, DONE], {}),
        ([PLAN, START, FAILED, PLAN], {}),
        ([PLAN, START, REFUSED], {}),
        ([PLAN, START, EPOCH], {}),
        ([PLAN, START, EPOCH, PLAN, START], {5: BROKEN_OFF}),
        ([PLAN, START, STUCK], {3: "stuck"}),
        ([PLAN, START, STUCK, LOST], {3: "stuck"}),
        ([PLAN, START, {**REFUSED, "outcome": "GiveUp"}], {3: "refused"}),
        ([PLAN, START, DONE, LOST], {4: "lost"}),
        ([PLAN, START, LOST], {2: f"{BROKEN_OFF}: lost"}),
        *(([PLAN, START, DONE, end(word)], {}) for word in ("Success", "Fail", "Cancelled", "Error")),
    ],
)
def test_open_action_of_a_real_robot_and_a_give_up_wait(
    records: list[dict[str, Any]], waits: dict[int, str]
) -> None:
    assert found(*records) == waits


@pytest.mark.parametrize(
    ("records", "number", "waits"),
    [
        ([PLAN, START, STUCK], 3, {}),
        ([PLAN, START, STUCK], 2, {3: "stuck"}),
        ([PLAN, START], 2, {}),
        ([PLAN, START], 1, {2: BROKEN_OFF}),
        ([PLAN, START, INTENT], 3, {2: BROKEN_OFF}),
        ([PLAN, START, LOST], 2, {}),
        ([PLAN, START, LOST], 3, {2: BROKEN_OFF}),
        ([PLAN, START, DONE, LOST], 4, {}),
    ],
)
def test_acknowledged_record_waits_no_more(
    records: list[dict[str, Any]], number: int, waits: dict[int, str]
) -> None:
    assert found(*records, ack(number)) == waits


def test_simulated_run_waits_for_a_give_up_alone() -> None:
    """Its world is put back to where it was before the action."""
    assert found(PLAN, START, simulated=True) == {}
    assert found(PLAN, simulated=True, torn=True) == {}
    assert found(PLAN, START, STUCK, simulated=True) == {3: "stuck"}


@pytest.mark.parametrize(
    ("records", "waits"),
    [
        ([], {}),
        ([PLAN], {2: "record 2 is damaged: an action may have begun"}),
        ([PLAN, START], {2: BROKEN_OFF}),
        ([PLAN, START, DONE], {4: "record 4 is damaged: an action may have begun"}),
        ([PLAN, START, STUCK, ack(3)], {5: "record 5 is damaged: an action may have begun"}),
        ([PLAN, START, DONE, end("Cancelled")], {}),
    ],
)
def test_damaged_record_waits_where_an_action_may_have_begun(
    records: list[dict[str, Any]], waits: dict[int, str]
) -> None:
    """D3"""
    assert found(*records, torn=True) == waits


def test_journal_without_records_waits_for_nobody() -> None:
    assert waiting(JournalContents((), None, 0)) == {}
