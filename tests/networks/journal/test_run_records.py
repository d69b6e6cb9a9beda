"""Fields of every record of a journal, whatever its kind."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.networks.journal.run_records import RECORD_VALIDATORS, makes_sense

STOP = {
    "q": 3,
    "kind": "STOP",
    "t": 1.5,
    "wall": {"unix_s": 2.0},
    "cause": "STOP",
    "asked_s": 1.0,
    "sent_s": 1.1,
}


def test_a_record_with_all_that_it_needs_makes_sense() -> None:
    assert makes_sense(STOP) == ""
    assert makes_sense({**STOP, "more": 1}) == ""


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({"t": None}, "t: Input should be a valid number"),
        ({"t": "1.5"}, "t: Input should be a valid number"),
        ({"t": float("nan")}, "t: Input should be a finite number"),
        ({"wall": {}}, "wall.unix_s: Field required"),
        ({"wall": 2.0}, "wall: Input should be a valid dictionary"),
        ({"sent_s": "soon"}, "sent_s: Input should be a valid number"),
        ({"kind": "STOPP"}, "no such kind; allowed: RUN, PLAN"),
        ({"kind": 3}, "no such kind"),
        ({"kind": "RUN"}, "a journal begins with RUN, and has one"),
        ({"q": 0}, "a journal begins with RUN, and has one"),
    ],
)
def test_a_record_that_lacks_what_all_have_is_named(change: dict[str, Any], wrong: str) -> None:
    assert makes_sense({**STOP, **change}).startswith(wrong)


@pytest.mark.parametrize("kind", sorted(RECORD_VALIDATORS))
def test_no_kind_of_record_does_without_its_time(kind: str) -> None:
    assert makes_sense({"q": 0 if kind == "RUN" else 1, "kind": kind}) == "t: Field required"
