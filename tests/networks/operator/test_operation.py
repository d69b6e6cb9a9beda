"""What an operator asks for while a run goes on, and what everybody sees of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.events import Started
from handcart.networks.operator.operation import Operation
from handcart.networks.operator.permits import Permits
from tests.networks.conftest import Stand


@pytest.fixture
def run(stand: Stand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A run of three actions, a to d, that goes on by one period at a time."""
    monkeypatch.chdir(tmp_path)
    started: list[str] = []

    def hear(event: object) -> None:
        if isinstance(event, Started):
            started.append(event.action.source)

    permits = Permits()
    network = stand.network("a b go 1", "b c go 1", "c z go 1")
    coordinator = Coordinator(network, stand.robot, stand.model, observers=[hear], permission=permits)
    with Operation(Path(), coordinator, permits, stand.robot) as operation:
        periods = coordinator.run()
        double: Any = operation
        double.started = started

        def go_on(count: int = 30) -> None:
            for _ in range(count):
                if next(periods, None) is None and coordinator.situation == "z":
                    return

        double.go_on = go_on
        yield double


def test_single_steps_begin_and_end_while_it_goes_on(run: Any) -> None:
    assert run.answer({"do": "step"})["step"]
    run.go_on()
    assert run.started == []
    asks = run.answer({"do": "status"})["asks"]
    assert (asks["from"], asks["ask"]) == ("a", 1)
    assert run.answer({"do": "permit", "ask": 1})["ok"]
    run.go_on()
    assert run.started == ["a"]
    assert run.answer({"do": "status"})["asks"]["ask"] == 2
    assert not run.answer({"do": "step", "on": False})["step"]
    run.go_on()
    assert run.started == ["a", "b", "c"]


def test_a_restore_while_an_action_waits_is_not_its_own(run: Any) -> None:
    run.answer({"do": "step"})
    run.go_on()
    for message in ({"do": "restore"}, {"do": "restore", "number": 1}, {"do": "cancel", "number": 1}):
        answer = run.answer(message)
        assert not answer["ok"]
        assert "; allowed: " in answer["error"]
    assert run.answer({"do": "status"})["acting"] is None
    run.answer({"do": "step", "on": False})
    run.answer({"do": "permit", "ask": 1})
    run.go_on()
    assert run.started == ["a", "b", "c"]


def test_break_points_come_and_go(run: Any) -> None:
    assert run.answer({"do": "break", "at": "b"})["breaks"] == ["b"]
    assert run.answer({"do": "break", "at": "c"})["breaks"] == ["b", "c"]
    run.go_on()
    assert run.started == ["a"]
    assert run.answer({"do": "break", "at": "c", "on": False})["breaks"] == ["b"]
    assert run.answer({"do": "permit"})["ok"]
    run.go_on()
    assert run.started == ["a", "b", "c"]
    wrong = run.answer({"do": "break", "at": "nowhere"})
    assert wrong == {"ok": False, "error": "at is 'nowhere'; allowed: a situation of the task"}


def test_u7_an_answer_holds_for_the_question_it_was_given_to(run: Any) -> None:
    """A second click, or a message that was kept and sent again, permits nothing else."""
    run.answer({"do": "step"})
    run.go_on()
    first = {"do": "permit", "ask": 1, "nonce": "once"}
    assert "again" not in run.answer(first)
    assert run.answer(first)["again"]
    run.go_on()
    assert run.started == ["a"]
    assert run.answer(first)["again"]
    late = run.answer({"do": "permit", "ask": 1})
    assert "question 1 is over; what waits is question 2" in late["error"]
    run.go_on()
    assert run.started == ["a"]


def test_u7_a_replayed_step_does_nothing(run: Any) -> None:
    assert not run.answer({"do": "step", "on": False, "nonce": "n1"})["step"]
    assert run.answer({"do": "step"})["step"]
    again = run.answer({"do": "step", "on": False, "nonce": "n1"})
    assert (again["again"], again["step"]) == (True, True)


def test_u8_everybody_sees_what_everybody_said(run: Any) -> None:
    run.answer({"do": "break", "at": "b", "by": "Ada"})
    run.answer({"do": "step"})
    run.answer({"do": "jump", "by": "Eve"})
    said = [(each["number"], each["by"], each["do"]) for each in run.answer({"do": "status"})["commands"]]
    assert said == [(1, "Ada", "break"), (2, "the terminal", "step")]
    for _ in range(30):
        run.answer({"do": "step"})
    assert len(run.answer({"do": "status"})["commands"]) == 20


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({"do": "step", "on": 1}, "on is 1; allowed: true, false"),
        ({"do": "pause", "by": 7}, "by is 7; allowed: text of at most 80 letters"),
        ({"do": "pause", "nonce": "x" * 81}, "allowed: text of at most 80 letters"),
        ({"do": "permit", "ask": True}, "the question True is no number; allowed: the question's number"),
        ({"do": "pause", "at": "a"}, "unknown key 'at'; allowed: by, do, nonce"),
    ],
)
def test_what_is_wrong_is_told(run: Any, message: dict[str, Any], words: str) -> None:
    answer = run.answer(message)
    assert not answer["ok"]
    assert words in answer["error"]
