"""Requests of an operator during a run, and their visible effects."""

from __future__ import annotations

import selectors
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.events.events import Started
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.operator.asking import tell_to_stop
from handcart.networks.operator.operation import Operation
from handcart.networks.operator.permits import Permits
from tests.networks.conftest import Stand


@pytest.fixture
def run(stand: Stand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Yield a run of three actions, a to d, that continues by one period at a time."""
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
        double.started, double.permits, double.robot = started, permits, stand.robot

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


def test_how_things_stand_is_told_whole(run: Any) -> None:
    nothing: dict[str, Any] = {
        "acting": None,
        "unapplied": [],
        "sim_time_s": 0.0,
        "asks": None,
        "breaks": [],
        "commands": [],
    }
    begun = {"state": "planning", "situation": "a", "actions": 0, "step": False, **nothing}
    assert run.answer({"do": "status"}) == {"ok": True, **begun}
    run.answer({"do": "step", "by": "Ada"})
    run.go_on(3)
    status = run.answer({"do": "status"})
    question = {"index": 0, "do": "THINK", "from": "a", "to": "b", "with": {"name": "go"}}
    assert (status["state"], status["step"]) == ("waiting for permission", True)
    assert status["asks"] == {**question, "ask": 1}
    assert status["commands"] == [{"number": 1, "do": "step", "by": "Ada", "sim_time_s": 0.0}]


def test_an_answer_to_nothing_or_to_another_action_is_none(run: Any) -> None:
    assert run.answer({"do": "permit"}) == {"ok": False, "error": "no action waits for permission"}
    run.answer({"do": "step"})
    run.go_on(3)
    wrong = run.answer({"do": "refuse", "action": 1})["error"]
    assert wrong == "action 1 doesn't wait for permission; waiting is 0: THINK (a to b)"
    late = run.answer({"do": "refuse", "ask": 2})["error"]
    assert late == "question 2 is over; waiting is question 1: THINK (a to b)"
    run.go_on(3)
    assert run.started == []
    assert run.answer({"do": "permit", "action": 0, "ask": 1})["ok"]
    run.answer({"do": "step", "on": False})
    run.go_on(3)
    assert run.started == ["a", "b", "c"]


def test_a_refused_action_is_not_started_and_asked_for_again(run: Any) -> None:
    run.answer({"do": "break", "at": "b"})
    for ask in (1, 2, 3):
        run.go_on(4)
        assert run.answer({"do": "refuse", "ask": ask})["ok"]
    run.go_on(4)
    assert run.started == ["a"]
    assert run.answer({"do": "status"})["state"] == "ended"


def test_while_it_waits_a_period_lasts_on_the_wall_clock(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A period does not wait while the robot moves; typed input is read only while the run waits."""
    waited: list[float | None] = []
    typed: list[bool | None] = [None, True]
    select = selectors.DefaultSelector.select

    def noted(self: selectors.DefaultSelector, timeout: float | None = None) -> Any:
        waited.append(timeout)
        return select(self, 0.0)

    monkeypatch.setattr(selectors.DefaultSelector, "select", noted)
    run.permits.typed = lambda: typed.pop(0)
    run.look()
    run.answer({"do": "break", "at": "a"})
    run.go_on(2)
    for _ in range(2):
        run.period(run.robot)
    assert waited == [0.0, 0.05, 0.05]
    assert typed == []
    run.go_on(3)
    assert run.started == ["a", "b", "c"]
    run.look()
    assert waited[-1] == 0.0


def test_a_line_that_stops_is_noted_as_the_terminals(run: Any, tmp_path: Path) -> None:
    tell_to_stop(tmp_path)
    run.look()
    (said,) = run.answer({"do": "status"})["commands"]
    assert said == {"number": 1, "do": "stop", "by": "the terminal", "sim_time_s": 0.0}
    run.go_on()
    assert run.started == []


def test_a_parameter_that_is_known_late_is_told_by_its_name(stand: Stand) -> None:
    late = Binding(stand.Think, {"name": "x" * 200}, {"text": "cup.size"})
    network = ActionNetwork.build([Situation("a"), Situation("z")], [Action("a", "z", late)], "a", "z")
    permits = Permits(step=True)
    permits(network.actions[0])
    with Operation(Path(), Coordinator(network, stand.robot, stand.model), permits, stand.robot) as operation:
        parameters = operation.status()["asks"]["with"]
    assert parameters["text"] == "cup.size"
    assert len(parameters["name"]) < 200


@pytest.mark.parametrize(
    ("mode", "permit", "step", "breaks", "answer"),
    [
        ("ask", False, False, (), True),
        ("ask", True, False, (), None),
        ("always", True, False, (), True),
        ("never", True, False, (), False),
        ("never", False, False, (), True),
        ("never", True, True, (), None),
        ("always", False, False, ("a",), None),
        ("always", False, False, ("z",), True),
    ],
)
def test_who_is_asked_depends_on_mode_step_and_breaks(
    mode: Any, permit: bool, step: bool, breaks: Any, answer: bool | None
) -> None:
    action = Action("a", "z", None, permit=permit)
    permits = Permits(mode, step, breaks)
    assert permits.asked == 0
    assert permits(action) is answer
    assert permits(action) is answer
    waits = answer is None
    assert (permits.asks, permits.asked) == (action if waits else None, int(waits))


def test_an_answer_given_before_the_question_is_lost() -> None:
    one, other = Action("a", "b", None), Action("b", "z", None)
    permits = Permits(step=True)
    permits.answer(True)
    assert permits(one) is None
    permits.answer(False)
    assert permits(other) is None
    permits.answer(True)
    permits.step = False
    assert permits(other) is True
    permits.step = True
    assert permits(other) is None
    assert permits.asked == 3


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
    """A second click, or a message that was kept and sent again, permits nothing more."""
    run.answer({"do": "step"})
    run.go_on()
    first = {"do": "permit", "ask": 1, "nonce": "once"}
    assert "again" not in run.answer(first)
    assert run.answer(first)["again"]
    run.go_on()
    assert run.started == ["a"]
    assert run.answer(first)["again"]
    late = run.answer({"do": "permit", "ask": 1})
    assert "question 1 is over; waiting is question 2" in late["error"]
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
    said = [
        (command["number"], command["by"], command["do"])
        for command in run.answer({"do": "status"})["commands"]
    ]
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
        ({"do": "permit", "ask": True}, "the question True is not a number; allowed: the question's number"),
        ({"do": "pause", "at": "a"}, "unknown key 'at'; allowed: by, do, nonce"),
    ],
)
def test_what_is_wrong_is_told(run: Any, message: dict[str, Any], words: str) -> None:
    answer = run.answer(message)
    assert not answer["ok"]
    assert words in answer["error"]
