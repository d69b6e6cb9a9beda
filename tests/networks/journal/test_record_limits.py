"""Least and greatest values that each kind of record may hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pytest

from handcart.networks.journal.run_records import RECORD_VALIDATORS, makes_sense

AT = {"base": [0.0, 1.0, 2.0], "base_sigma": [0.1, None]}
ACTION = {"index": 0, "do": "MOVE_TO", "from": "a", "to": "b"}
LEAST: Mapping[str, dict[str, Any]] = {
    "RUN": {},
    "PLAN": {"situation": "a"},
    "START": {"n": 1, "action": ACTION},
    "INTENT": {"n": 1, "effect": "the lamp goes out"},
    "PNR": {"n": 1, "what": "the lamp is out"},
    "STOP": {"cause": "asked", "asked_s": 1.0, "sent_s": 1.0},
    "RESTORE": {"n": 1, "reason": "blocked"},
    "RESULT": {"n": 1, "outcome": "Success"},
    "RECON": {"situation": None},
    "NOT_STARTED": {"action": 0, "reason": "refused"},
    "SKIP": {"action": 0, "element": "book 1"},
    "AIM": {"what": "abandon", "situation": "a"},
    "END": {"outcome": "Success", "situation": "z", "reason": ""},
    "ACK": {"record": 3, "of": "RESULT", "reason": "it squeaks"},
    "EPOCH": {"after": 3, "in_doubt": None},
}
"""The least that each kind holds."""


def record(kind: str, **more: Any) -> dict[str, Any]:
    common = {"q": 0 if kind == "RUN" else 1, "t": 0.5, "wall": {"unix_s": 1.7e9}, "kind": kind}
    return {**common, **LEAST.get(kind, {}), **more}


def test_the_least_of_each_kind_makes_sense_and_nothing_less() -> None:
    assert LEAST.keys() == RECORD_VALIDATORS.keys()
    for kind, fields in LEAST.items():
        whole = record(kind)
        assert makes_sense(whole) == "", kind
        for name in fields.keys() | {"t", "wall"}:
            wrong = makes_sense({key: value for key, value in whole.items() if key != name})
            assert wrong.endswith((": Field required", "Unable to extract tag using discriminator 'outcome'"))


@pytest.mark.parametrize(
    ("kind", "good", "bad"),
    [
        ("RUN", {"seed": 0}, {"seed": -1}),
        ("RUN", {"seed": 2**63 - 1}, {"seed": 2**63}),
        ("RUN", {"simulated": True}, {"simulated": 1}),
        ("RUN", {"bench": None}, {"backend": None}),
        ("START", {"n": 2**31 - 1}, {"n": 2**31}),
        ("START", {"n": 1}, {"n": 0}),
        ("START", {"n": 1}, {"n": 1.0}),
        ("START", {"action": {**ACTION, "index": 2**31 - 1}}, {"action": {**ACTION, "index": 2**31}}),
        ("START", {"action": {**ACTION, "with": {}}}, {"action": {**ACTION, "index": -1}}),
        ("START", {"at": AT}, {"at": {**AT, "base": [0.0, 1.0]}}),
        ("START", {"at": AT}, {"at": {**AT, "base": [0.0, 1.0, 2.0, 3.0]}}),
        ("START", {"at": AT}, {"at": {**AT, "base": [0.0, 1.0, None]}}),
        ("START", {"at": AT}, {"at": {**AT, "base": [0.0, 1.0, math.nan]}}),
        ("START", {"at": {**AT, "base_sigma": [None, None]}}, {"at": {**AT, "base_sigma": [None]}}),
        ("START", {"at": AT}, {"at": {**AT, "base_sigma": [0.1, 0.1, 0.1]}}),
        ("START", {"at": {**AT, "joints": [0.0] * 64}}, {"at": {**AT, "joints": [0.0] * 65}}),
        ("START", {"at": {**AT, "holding": False}}, {"at": {**AT, "holding": 0}}),
        ("PLAN", {"way": [0]}, {"way": [-1]}),
        ("PLAN", {"cost": 1.0}, {"cost": math.inf}),
        ("RESULT", {"residuals": {"held": None}}, {"residuals": {"held": "far"}}),
        (
            "RESULT",
            {"outcome": "Fail", "reason": "x", "permanent": False},
            {"outcome": "Fail", "reason": "x"},
        ),
        ("RESULT", {"outcome": "GiveUp", "reason": "x"}, {"outcome": "GiveUp"}),
        ("RESULT", {"cause": [{"reason": "x"}]}, {"cause": [{"check": "x"}]}),
        ("RESULT", {"more": 1}, {"outcome": "Error"}),
        ("RECON", {"situation": "a", "expected": None}, {"situation": 1}),
        ("END", {"outcome": "Error"}, {"outcome": "Happy"}),
        ("ACK", {"record": 0}, {"record": -1}),
        ("STOP", {"asked_s": 1}, {"asked_s": "1"}),
        ("SKIP", {"t": 0.0}, {"t": "0"}),
        ("SKIP", {"wall": {"unix_s": 1.0, "more": 1}}, {"wall": {}}),
    ],
)
def test_values_at_their_limits_are_taken_and_beyond_refused(
    kind: str, good: dict[str, Any], bad: dict[str, Any]
) -> None:
    assert makes_sense(record(kind, **good)) == ""
    wrong = makes_sense(record(kind, **bad))
    assert ": " in wrong
    assert "\n" not in wrong


def test_a_journal_begins_with_run_and_has_one() -> None:
    words = "a journal begins with RUN, and has one"
    assert makes_sense(record("RUN", q=1)) == words
    assert makes_sense(record("PLAN", q=0)) == words
    assert makes_sense(record("SKIP", t=None)) == "t: Input should be a valid number"


@pytest.mark.parametrize("kind", ["HALT", 7, None])
def test_a_kind_that_is_not_known_is_refused(kind: Any) -> None:
    assert makes_sense(record(kind)).startswith("no such kind; allowed: RUN, PLAN, START")
