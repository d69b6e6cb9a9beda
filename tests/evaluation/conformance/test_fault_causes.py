"""Injected faults lead to their causes: the table, and how the kit judges."""

from __future__ import annotations

import pytest

from handcart.evaluation.conformance.faults.expected_causes import (
    CAUSES_OF_FAULTS,
    CAUSES_OF_SENSORS,
    FALSIFIED_KINDS,
    expected_causes,
)
from handcart.evaluation.conformance.faults.fail_is_true import FaultTrial
from handcart.evaluation.conformance.faults.fault import PRIMITIVE_FAULTS, Fault, FaultKind, all_sensors
from handcart.evaluation.conformance.faults.underway import AttemptEnding
from handcart.evaluation.conformance.report import KitReport
from handcart.primitives.books.book_causes import JAMMED


def test_every_kind_and_sensor_is_in_the_table() -> None:
    assert {*CAUSES_OF_FAULTS, *FALSIFIED_KINDS} == set(PRIMITIVE_FAULTS)
    assert set(CAUSES_OF_SENSORS) == set(all_sensors())


@pytest.mark.parametrize(
    ("fault", "named", "not_named"),
    [
        (Fault(FaultKind.CANCEL), "cancelled", "time_out"),
        (Fault(FaultKind.NAN, "range"), "lost", "slipped"),
        (Fault(FaultKind.STALE, "width"), "slipped", "lost"),
        (Fault(FaultKind.WORLD, "a pebble", causes=(JAMMED,)), "jammed", "no_slot"),
    ],
)
def test_a_fault_leads_to_its_own_causes(fault: Fault, named: str, not_named: str) -> None:
    expected = expected_causes(fault)
    assert named in expected
    assert not_named not in expected


def trial(cause: str, outcome: str = "Fail", bitten: bool = True) -> FaultTrial:
    ending = AttemptEnding(outcome, "x", 9, bitten, cause=cause)
    return FaultTrial("REACH", 0, 7, "cancel", "cancel", ending, expected_causes(Fault(FaultKind.CANCEL)))


def report(right: int, wrong: int) -> KitReport:
    trials = [*[trial("cancelled")] * right, *[trial("time_out")] * wrong]
    return KitReport.of(
        "mine", "librarian", True, [[*trials, trial("", "Success"), trial("lost", bitten=False)]]
    )


@pytest.mark.parametrize(
    ("right", "wrong", "ok"), [(19, 1, True), (38, 3, False), (10, 5, True), (0, 20, False)]
)
def test_the_kit_allows_five_in_a_hundred(right: int, wrong: int, ok: bool) -> None:
    found = report(right, wrong)
    assert (found.ok, len(found.judged_causes), len(found.wrong_causes)) == (ok, right + wrong, wrong)
    line = f"{right} of {right + wrong} Fails and GiveUps name a cause"
    assert any(line in item and ("WRONG" in item) is not ok for item in found.lines())
    assert found.as_dict()["faults"]["causes"]["judged"] == right + wrong
