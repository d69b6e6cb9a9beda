"""Messages of an operator, with other clients that send anything."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from benchmarks.damage.fuzzed_messages import fuzzed_messages
from handcart.networks.coordination.supervision import MAX_REQUESTS as REQUESTS_THAT_WAIT
from handcart.networks.graph.network import Action
from handcart.networks.operator.control import Control
from handcart.networks.operator.permits import Permits
from tests.networks.conftest import Stand
from tests.networks.operator.conftest import Line

FAULT = "a fault in handcart"


def test_every_message_that_is_none_is_answered_in_words(run: Any, lines: Callable[[], Line]) -> None:
    """U11: of all JSON types, huge, deep, binary, half; more: `python -m benchmarks.hostile.control`."""
    taken = 0
    for message in fuzzed_messages(400, seed=1):
        line, rest = lines(), message + b"\n"
        answers: list[dict[str, Any]] = []
        while not answers:  # a line that is too long is answered before it is all there
            sent, rest = rest[:3000], rest[3000:]
            line.send(sent)
            run.look()
            answers = line.answers()
        (answer,) = answers
        assert answer["ok"] == is_taken(message), message
        assert answer["ok"] or ("allowed" in answer["error"] or "permission" in answer["error"]), message
        assert FAULT not in answer.get("error", "")
        taken += answer["ok"]
        line.socket.close()
        run.look()
    assert taken > 5
    assert run.coordinator.life.state.value == "planning"


def is_taken(line: bytes) -> bool:
    """Return whether a run obeys a line, as decided by Python's JSON."""
    try:
        message = json.loads(line) if len(line) <= 4096 else None
    except (ValueError, RecursionError):
        return False
    return message in ({"do": "status"}, {"do": "pause"}, {"do": "continue"})


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({"do": ["stop"]}, "unknown word ['stop']; allowed: pause, continue"),
        ({"do": {}}, "unknown word {}"),
        ({}, "the key 'do' is missing"),
        ({"do": "permit", "action": True}, "the action True is not a number"),
        ({"do": "permit", "action": 0.0}, "the action 0.0 is not a number"),
        ({"do": "permit", "acton": 3}, "unknown key 'acton'; allowed: action, ask, by, do, nonce"),
        ({"do": "x\x1b[2J"}, "unknown word 'x\\x1b[2J'"),
    ],
)
def test_what_is_wrong_with_a_message(run: Any, message: dict[str, Any], words: str) -> None:
    answer = run.answer(message)
    assert not answer["ok"]
    assert words in answer["error"]


def test_a_fault_in_answering_is_told_and_nothing_more(folder: Path, lines: Callable[[], Line]) -> None:
    def fails(message: Mapping[str, Any]) -> Mapping[str, Any]:
        raise KeyError("x")

    with Control(folder, fails, lambda: None) as listening:
        line = lines()
        line.send(b"{}\n")
        listening.poll()
        assert line.answers() == [{"ok": False, "error": "a fault in handcart: KeyError: 'x'"}]


def test_an_answer_holds_for_one_start_of_one_action(stand: Stand) -> None:
    (action,) = stand.network("a z go 1").actions
    permits = Permits(step=True)
    asked: list[Action] = []
    permits.asking = asked.append
    for permitted in (True, False):
        assert permits(action) is None
        permits.answer(permitted)
        assert permits(action) is permitted
    assert permits(action) is None
    assert asked == [action] * 3


def test_waiting_requests_are_limited_but_a_stop_is_not(run: Any) -> None:
    taken = [run.answer({"do": word})["ok"] for _ in range(50) for word in ("pause", "continue")]
    assert taken == [True] * REQUESTS_THAT_WAIT + [False] * (100 - REQUESTS_THAT_WAIT)
    assert run.answer({"do": "stop"})["ok"]
    assert run.stand.finish(run.coordinator).outcome == "Cancelled"
