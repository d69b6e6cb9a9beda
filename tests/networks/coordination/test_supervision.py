"""When a stop is heard: at once, in whatever the run waits for."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.run_life import RunState
from handcart.networks.coordination.supervision import MAX_REQUESTS, MAX_UNAPPLIED, Request
from handcart.networks.events.events import Event, LeftOut, Planned
from handcart.networks.events.run_end import RunEnd
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from tests.networks.conftest import Stand

ENDS = {
    Request.STOP: "stopped by request",
    Request.INTERRUPT: "interrupted",
    Request.CANCEL: "cancelled by request",
}


class SlowDisk(Journal):
    """Journal that brings a kind of record to the disk only on command."""

    slow: ClassVar[str] = "RESULT"
    safe = True

    def append(self, kind: str, *fields: Any) -> int:
        self.safe = self.safe and kind != self.slow
        return super().append(kind, *fields)

    @property
    def durable(self) -> bool:
        return self.safe


class Closed(ActionPrimitive):
    """Primitive that drives, and records the number of stop commands before it is closed."""

    needs: ClassVar = (Base,)
    stops: ClassVar[list[int]] = []

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        try:
            for _ in range(60):
                robot.base.drive(0.2, 0.0)
                yield
        finally:
            self.stops.append(robot.backend.stops)  # type: ignore[attr-defined]


def step(stand: Stand, run: Coordinator, periods: Generator[None, None, RunEnd], count: int = 1) -> None:
    for _ in range(count):
        next(periods)
        stand.robot.step(run.life.paused)


def kinds(journal: Journal) -> list[str]:
    return [record["kind"] for record in read_journal(journal.path).records]


def drive_network(stand: Stand, *kinds: ActionPrimitive) -> ActionNetwork:
    names = "abcdefgh"[: len(kinds)] + "z"
    actions = [
        Action(names[i], names[i + 1], Binding.of(kind), 1.0, 1, time_out_s=None)
        for i, kind in enumerate(kinds)
    ]
    return ActionNetwork.build(map(Situation, names), actions, "a", "z")


@pytest.mark.parametrize("what", ENDS)
def test_stop_while_a_result_waits_for_the_disk_is_heard_at_once(
    stand: Stand, tmp_path: Path, what: Request
) -> None:
    journal = SlowDisk(tmp_path / "j")
    with journal:
        run = Coordinator(drive_network(stand, stand.Drive(periods=3)), stand.robot, stand.model, journal)
        periods = run.run()
        while "RESULT" not in kinds(journal):
            step(stand, run, periods)
        step(stand, run, periods, 30)
        assert kinds(journal)[-1] == "RESULT"
        run.ask(what)
        asked, stops = stand.robot.time, stand.backend.stops
        step(stand, run, periods)
        assert stand.backend.stops == stops + 1
        *_, stop, end = read_journal(journal.path).records
        assert (stop["kind"], stop["cause"], stop["asked_s"]) == ("STOP", ENDS[what], round(asked, 6))
        assert (end["kind"], end["outcome"], end["reason"]) == ("END", "Cancelled", ENDS[what])
        step(stand, run, periods, 5)  # the requester hears how it ended only when it is safe
        journal.safe = True
        with pytest.raises(StopIteration):
            next(periods)
    assert run.life.state is RunState.ENDED


@pytest.mark.parametrize("what", ENDS)
def test_stop_while_a_result_waits_keeps_that_result(stand: Stand, tmp_path: Path, what: Request) -> None:
    events: list[Event] = []
    network = drive_network(stand, stand.Drive(periods=3), stand.Drive())
    journal = SlowDisk(tmp_path / "j")
    with journal:
        run = Coordinator(network, stand.robot, stand.model, journal, [events.append])
        periods = run.run()
        while "RESULT" not in kinds(journal):
            step(stand, run, periods)
        run.ask(what)
        step(stand, run, periods)
        journal.safe = True
        with pytest.raises(StopIteration) as ended:
            next(periods)
    end = ended.value.value
    assert (end.outcome, end.situation) == ("Cancelled", "b")
    assert [type(event).__name__ for event in events[-2:]] == ["Ended", "RunEnded"]


def test_cancel_counts_its_fail_though_it_waits_for_the_disk(stand: Stand, tmp_path: Path) -> None:
    journal = SlowDisk(tmp_path / "j")
    with journal:
        run = Coordinator(drive_network(stand, stand.Drive(periods=60)), stand.robot, stand.model, journal)
        periods = run.run()
        step(stand, run, periods, 30)
        run.ask(Request.CANCEL)
        while "END" not in kinds(journal):
            step(stand, run, periods)
        journal.safe = True
        with pytest.raises(StopIteration) as ended:
            next(periods)
    assert (ended.value.value.outcome, ended.value.value.fails) == ("Cancelled", 1)


def test_stop_while_a_give_up_waits_for_the_disk_leaves_it(stand: Stand, tmp_path: Path) -> None:
    """A person is still needed, so the run must not end as merely cancelled."""
    stand.script["go"] = deque("G")
    journal = SlowDisk(tmp_path / "j")
    with journal:
        run = Coordinator(stand.network("a z go 1"), stand.robot, stand.model, journal)
        periods = run.run()
        while "RESULT" not in kinds(journal):
            step(stand, run, periods)
        run.ask(Request.STOP)
        step(stand, run, periods)
        journal.safe = True
        with pytest.raises(StopIteration) as ended:
            next(periods)
    assert (ended.value.value.outcome, ended.value.value.exit_status) == ("GiveUp", 4)


@pytest.mark.parametrize("what", ENDS)
def test_stop_between_two_actions_plans_nothing_more(stand: Stand, what: Request) -> None:
    """An action that was refused leads to another plan: a stop goes before that."""
    events: list[Event] = []

    def hear(event: Event) -> None:
        events.append(event)
        if isinstance(event, LeftOut):
            run.ask(what)

    network = stand.network("a z one 1 1", "a z two 2 1")
    run = Coordinator(
        network, stand.robot, stand.model, observers=[hear], permission=lambda action: action.cost_s > 1.0
    )
    end = stand.finish(run)
    assert (end.outcome, end.reason, end.actions, end.fails) == ("Cancelled", ENDS[what], 0, 1)
    assert [type(event_).__name__ for event_ in events] == ["Planned", "LeftOut", "RunEnded"]
    assert isinstance(events[0], Planned)
    assert stand.backend.stops == 1


@pytest.mark.parametrize("what", ENDS)
def test_stop_while_an_action_waits_for_permission_is_heard(stand: Stand, what: Request) -> None:
    run = Coordinator(stand.network("a z go 1"), stand.robot, stand.model, permission=lambda action: None)
    periods = run.run()
    step(stand, run, periods, 4)
    assert run.life.state is RunState.WAITING_FOR_PERMISSION
    assert run.asks is run.network.actions[0]
    run.ask(what)
    with pytest.raises(StopIteration) as ended:
        next(periods)
    assert (ended.value.value.outcome, ended.value.value.reason) == ("Cancelled", ENDS[what])
    assert stand.backend.stops == 1


@pytest.mark.parametrize("what", [Request.STOP, Request.INTERRUPT])
def test_stop_in_an_action_goes_before_closing_it(stand: Stand, tmp_path: Path, what: Request) -> None:
    """The robot stops before the action is closed, and once more after it; then it comes to rest."""
    Closed.stops.clear()
    with Journal(tmp_path / "j") as journal:
        run = Coordinator(drive_network(stand, Closed()), stand.robot, stand.model, journal)
        periods = run.run()
        step(stand, run, periods, 30)
        assert stand.backend.stops == 0
        run.ask(Request.PAUSE)  # waits longer, and is not heard
        run.ask(what)
        asked = stand.robot.time
        step(stand, run, periods)
        assert (Closed.stops, stand.backend.stops) == ([1], 2)
        travel = stand.backend.wheels.travel
        rest = 0
        with pytest.raises(StopIteration):
            while True:
                next(periods)
                stand.robot.step()
                rest += 1
        assert stand.backend.wheels.travel == travel
        assert rest >= 4
        stop = next(record for record in read_journal(journal.path).records if record["kind"] == "STOP")
    assert (stop["cause"], stop["asked_s"]) == (ENDS[what], round(asked, 6))
    assert stop["sent_s"] == pytest.approx(asked, abs=1e-6)


def test_first_of_two_stops_names_the_cause(stand: Stand) -> None:
    run = Coordinator(drive_network(stand, stand.Drive()), stand.robot, stand.model)
    both = {20: lambda: [run.ask(Request.INTERRUPT), run.ask(Request.STOP)]}
    assert stand.finish(run, both).reason == "interrupted"


def test_after_a_cancel_no_further_action_starts(stand: Stand) -> None:
    """Also where what it called back ends in Success."""
    run = Coordinator(drive_network(stand, stand.Drive(), stand.Drive()), stand.robot, stand.model)
    end = stand.finish(run, {20: lambda: run.ask(Request.CANCEL)})
    assert (end.outcome, end.reason, end.actions, end.situation) == (
        "Cancelled",
        "cancelled by request",
        1,
        "a",
    )


def test_requests_that_wait_are_limited_to_a_number(stand: Stand) -> None:
    run = Coordinator(drive_network(stand, stand.Drive()), stand.robot, stand.model)
    answers = [run.ask(Request.PAUSE) for _ in range(MAX_REQUESTS + 1)]
    assert answers[:-1] == [""] * MAX_REQUESTS
    assert answers[-1] == "too much is asked for at once; allowed: to wait until it is done, and to stop"
    assert not run.request(Request.PAUSE)
    assert run.request(Request.STOP)


def test_too_late_requests_are_kept_up_to_a_number(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of dozens of requests in the last period of an action, the latest ones are reported."""
    run = Coordinator(drive_network(stand, stand.Drive(periods=3)), stand.robot, stand.model)
    asked: list[str] = []

    def ask(*_: object) -> None:
        asked.extend(run.ask(Request.RESTORE) for _ in range(MAX_UNAPPLIED + 5))

    monkeypatch.setattr("handcart.primitives.contract.unmet.note_hand", ask)
    assert stand.finish(run).fails == 0
    assert asked == [""] * (MAX_UNAPPLIED + 5)
    time = f"{stand.robot.time:.3f} s"
    assert run.unapplied[0] == f"restore of action 1, asked for at {time}: that action was over"
    assert len(run.unapplied) == MAX_UNAPPLIED == 20


@pytest.mark.parametrize(
    ("ask", "answer"),
    [
        (lambda run: run.ask(Request.PAUSE, 1), "action 1 has not begun; allowed: an action that runs; none"),
        (lambda run: run.ask(Request.RESTORE), "no action runs, so there is nothing to restore"),
        (lambda run: run.ask(Request.RESUME), "nothing is paused; allowed: after a pause"),
        (lambda run: [run.ask(Request.PAUSE), run.ask(Request.RESUME)][1], ""),
        (lambda run: run.ask(Request.CANCEL), ""),
    ],
)
def test_answers_before_anything_runs_say_why(
    stand: Stand, ask: Callable[[Coordinator], str], answer: str
) -> None:
    run = Coordinator(drive_network(stand, stand.Drive()), stand.robot, stand.model)
    said = ask(run)
    assert said.startswith(answer) if answer else said == ""


def test_restore_is_taken_once_and_is_the_actions_fail(stand: Stand) -> None:
    run = Coordinator(drive_network(stand, stand.Drive(periods=60)), stand.robot, stand.model)
    periods, said = run.run(), []
    step(stand, run, periods, 30)
    said.append(run.ask(Request.RESTORE, 1))
    step(stand, run, periods, 2)
    states = [run.life.state]
    said += [run.ask(Request.RESTORE), run.ask(Request.RESTORE, 1), run.ask(Request.PAUSE)]
    step(stand, run, periods, 2)
    states.append(run.life.state)
    said += [run.ask(Request.RESTORE), run.ask(Request.RESUME)]
    with pytest.raises(StopIteration) as ended:
        step(stand, run, periods, 10_000)
    assert states == [RunState.RESTORING, RunState.PAUSED_WHILE_RESTORING]
    once = "action 1 is being restored already; allowed: once"
    assert said == ["", once, once, "", once, ""]
    assert (ended.value.value.outcome, ended.value.value.fails) == ("Fail", 1)
    assert abs(stand.robot.pose.x) < 0.02


def test_one_more_pause_does_not_end_a_pause(stand: Stand) -> None:
    run = Coordinator(drive_network(stand, stand.Drive()), stand.robot, stand.model)
    held: list[bool] = []
    at: dict[int, Callable[[], object]] = {
        period: lambda: held.append(run.life.paused) for period in range(22, 60)
    }
    at |= {period: lambda: run.ask(Request.PAUSE) for period in (20, 30, 31, 40)}
    at[60] = lambda: run.ask(Request.RESUME)
    end = stand.finish(run, at)
    assert held
    assert all(held)
    assert end.outcome == "Success"
