"""Requests are applied to the action that they are meant for, or answered in words."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.network_behaviour import NetworkBehaviour
from handcart.networks.coordination.run_life import RunState
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.events import Ended, Event, Planned, Started
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.operator.message import fault_of
from tests.networks.conftest import Stand

PERIODS = 12


def two_drives(stand: Stand) -> ActionNetwork:
    bound = Binding.of(stand.Drive(periods=PERIODS))
    actions = [Action("a", "b", bound, 1.0, 1), Action("b", "z", bound, 1.0, 1)]
    return ActionNetwork.build([Situation(name) for name in "abz"], actions, "a", "z")


def outcomes(events: list[Event]) -> list[tuple[int, str]]:
    return [(event.number, type(event.outcome).__name__) for event in events if isinstance(event, Ended)]


def ask_to_restore(run: Coordinator, asked: list[tuple[int | None, str]]) -> None:
    """Note which action ran then, and the answer."""
    asked.append((run.acting, run.ask(Request.RESTORE)))


def run_asking(stand: Stand, ask: Callable[[Coordinator, Event], None]) -> tuple[Any, list[Event]]:
    """A run of two actions, `ask` called at each event."""
    events: list[Event] = []
    run = Coordinator(two_drives(stand), stand.robot, stand.model, observers=[events.append])
    run._log._observers = (*run._log._observers, lambda event: ask(run, event))
    return stand.finish(run), events


def test_restore_between_two_actions_is_refused_in_words(stand: Stand) -> None:
    said = []

    def ask(run: Coordinator, event: Event) -> None:
        if isinstance(event, Ended):
            said.append(run.ask(Request.RESTORE))

    end, events = run_asking(stand, ask)
    assert end.outcome == "Success"
    assert outcomes(events) == [(1, "Success"), (2, "Success")]
    assert said == ["no action runs, so there is nothing to restore; allowed: while one runs"] * 2


def test_restore_while_a_permit_is_pending_is_refused(stand: Stand) -> None:
    answers = iter([True, None, None, True])
    said = []
    run = Coordinator(two_drives(stand), stand.robot, stand.model, permission=lambda action: next(answers))

    def ask() -> None:
        if run.life.state is RunState.WAITING_FOR_PERMISSION:
            said.append(run.request(Request.RESTORE))

    end = stand.finish(run, dict.fromkeys(range(200), ask))
    assert said == [False, False]
    assert (end.outcome, end.fails) == ("Success", 0)


def test_restore_in_the_last_period_of_an_action_is_its_own(stand: Stand) -> None:
    """Asked for in each of its periods: the action that ran then fails, and no other."""
    for period in range(1, 80):
        events: list[Event] = []
        run = Coordinator(two_drives(stand), stand.robot, stand.model, observers=[events.append])
        asked: list[tuple[int | None, str]] = []
        end = stand.finish(run, {period: partial(ask_to_restore, run, asked)})
        if not asked:
            assert end.outcome == "Success"
            return
        (number, refused), ended = asked[0], dict(outcomes(events))
        assert bool(refused) == (number is None)
        assert [n for n, word in ended.items() if word == "Fail"] == ([number] if number else [])
    raise AssertionError("the run never ended by itself")


@pytest.mark.parametrize("what", [Request.PAUSE, Request.CANCEL, Request.RESTORE, Request.RESUME])
def test_a_request_that_names_another_action_is_not_applied(stand: Stand, what: Request) -> None:
    said = []

    def ask(run: Coordinator, event: Event) -> None:
        if isinstance(event, Started) and event.number == 2:
            said.extend([run.ask(what, 1), run.ask(what, 3)])

    end, events = run_asking(stand, ask)
    assert said == [
        "action 1 is over; allowed: 2, which runs",
        "action 3 has not begun; allowed: 2, which runs",
    ]
    assert outcomes(events) == [(1, "Success"), (2, "Success")]
    assert end.outcome == "Success"


def test_a_request_that_comes_too_late_is_kept_in_words(
    stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A request in the very period in which the action succeeds is too late to be honoured."""
    events: list[Event] = []
    taken: list[bool] = []
    run = Coordinator(two_drives(stand), stand.robot, stand.model, observers=[events.append])

    def ask(*_: object) -> None:
        if run.acting == 1:
            taken.append(run.request(Request.RESTORE))

    monkeypatch.setattr("handcart.primitives.contract.unmet.note_hand", ask)
    end = stand.finish(run)
    assert taken == [True]
    assert outcomes(events) == [(1, "Success"), (2, "Success")]
    (late,) = run.unapplied
    assert late.startswith("restore of action 1, asked for at ")
    assert end.fails == 0


@pytest.mark.parametrize("what", [Request.STOP, Request.CANCEL])
def test_asked_to_end_while_it_plans_starts_no_action(stand: Stand, what: Request) -> None:
    def ask(run: Coordinator, event: Event) -> None:
        if isinstance(event, Planned):
            run.request(what)

    end, events = run_asking(stand, ask)
    assert (end.outcome, end.actions) == ("Cancelled", 0)
    assert not any(isinstance(item, Started) for item in events)


@pytest.mark.parametrize("what", [Request.STOP, Request.CANCEL])
def test_asked_to_end_at_the_last_result_it_is_heard(stand: Stand, what: Request) -> None:
    def ask(run: Coordinator, event: Event) -> None:
        if isinstance(event, Ended) and event.number == 2:
            run.request(what)

    end, _ = run_asking(stand, ask)
    assert (end.outcome, end.situation) == ("Cancelled", "z")


def test_a_restore_at_the_start_of_an_action_is_its_own(stand: Stand) -> None:
    def ask(run: Coordinator, event: Event) -> None:
        if isinstance(event, Started) and event.number == 1:
            run.request(Request.RESTORE)

    _, events = run_asking(stand, ask)
    assert outcomes(events)[0] == (1, "Fail")


def test_a_stop_stops_whatever_action_it_names(stand: Stand) -> None:
    run = Coordinator(two_drives(stand), stand.robot, stand.model)
    end = stand.finish(run, {5: lambda: run.request(Request.STOP, 7)})
    assert (end.outcome, end.reason) == ("Cancelled", "stopped by request")


def test_after_the_end_requests_are_answered(stand: Stand) -> None:
    run = Coordinator(two_drives(stand), stand.robot, stand.model)
    stand.finish(run)
    assert [run.ask(what) for what in (Request.PAUSE, Request.RESTORE)] == [
        "the run is over; allowed: while it runs"
    ] * 2


def test_continue_without_a_pause_is_answered(stand: Stand) -> None:
    said: list[str] = []
    run = Coordinator(two_drives(stand), stand.robot, stand.model)
    stand.finish(run, {5: lambda: said.append(run.ask(Request.RESUME))})
    assert said == ["nothing is paused; allowed: after a pause"]


def test_a_network_interrupted_between_actions_fails_no_action(stand: Stand) -> None:
    """In each period an interrupted action is restored, and an action that was not begun is not."""
    from py_trees.common import Status

    answers = [None] * 6
    network, runs = two_drives(stand), []

    def make() -> Coordinator:
        asks = iter([True, *answers, True])
        runs.append(Coordinator(network, stand.robot, stand.model, permission=lambda action: next(asks)))
        return runs[-1]

    behaviour = NetworkBehaviour("network", stand.robot, make)
    behaviour.initialise()
    while behaviour.update() is Status.RUNNING:
        if runs[-1].life.state is RunState.WAITING_FOR_PERMISSION and not stand.backend.stops:
            behaviour.terminate(Status.INVALID)
            behaviour.initialise()
        stand.robot.step()
    assert behaviour.end is not None
    assert (behaviour.end.outcome, behaviour.end.fails) == ("Success", 0)


def test_a_message_names_the_action_by_a_number() -> None:
    assert fault_of({"do": "restore", "number": 3}, ()) == ""
    assert "the running action 'x' is not a number" in fault_of({"do": "cancel", "number": "x"}, ())
    assert "unknown key" in fault_of({"do": "status", "number": 3}, ())
