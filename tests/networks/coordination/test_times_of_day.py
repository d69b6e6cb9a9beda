"""Rounds and interrupts at times of day."""

from __future__ import annotations

import time as clocks
from collections.abc import Callable, Iterator
from datetime import datetime, time
from itertools import islice
from pathlib import Path

import pytest
from typing_extensions import override

from handcart.files.errors import FileError
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.day_clock import LocalDay, RehearsedDay, after
from handcart.networks.events.events import AimChanged, Event
from handcart.networks.events.run_end import RunEnd
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.networks.past_runs.journaled_network import network_of
from handcart.networks.runs.day_of_run import began_at
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.task_file import Task
from tests.networks.conftest import Stand

Load = Callable[..., Task]
HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\n"
CIRCLE = """\
start: home
goal: [shelf, home]
situations: {home: {}, shelf: {}, door: {}}
actions:
  - {do: DRIVE, from: home, to: shelf, cost_s: 2}
  - {do: DRIVE, from: shelf, to: home, cost_s: 2}
  - {do: DRIVE, from: home, to: door, cost_s: 2}
  - {do: DRIVE, from: door, to: home, cost_s: 2}
"""
TWICE = f'{HEAD}rounds: {{most: 2, at: ["09:00", "09:00:12"]}}\n{CIRCLE}'


def run(task: Task, stand: Stand, begins: str, path: Path) -> tuple[RunEnd, list[Event]]:
    """Run a task on a day that begins at a time, with a journal that can be retraced."""
    events: list[Event] = []
    with Journal(path) as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": task.network.fingerprint()})
        clock = RehearsedDay(stand.robot, time.fromisoformat(begins))
        end = stand.finish(
            Coordinator(task.network, stand.robot, stand.model, journal, [events.append], clock=clock)
        )
    records = read_journal(path).records
    standing(task.network, records)
    assert network_of(network_fields(task.network)).network.aims == task.network.aims
    return end, events


def starts(path: Path) -> list[float]:
    return [record["t"] for record in read_journal(path).records if record["kind"] == "START"]


def test_rounds_wait_for_their_times_of_day(load: Load, stand: Stand, tmp_path: Path) -> None:
    end, events = run(load(TWICE), stand, "08:59:57", tmp_path / "j")
    assert (end.outcome, end.rounds) == ("Success", 2)
    first, _, second, _ = starts(tmp_path / "j")
    assert first == pytest.approx(3.0, abs=0.2)
    assert second == pytest.approx(15.0, abs=0.2)
    said = [event.words for event in events if isinstance(event, AimChanged)]
    assert said == ["round 1 begins at 09:00:00", "round 2 begins at 09:00:12"]


def test_times_that_pass_during_a_round_begin_none(load: Load, stand: Stand, tmp_path: Path) -> None:
    text = TWICE.replace('"09:00:12"', '"09:00:01", "09:00:12"')
    run(load(text), stand, "09:00", tmp_path / "j")
    assert starts(tmp_path / "j")[2] == pytest.approx(12.0, abs=0.2)


def test_time_out_counts_from_the_time_of_day(load: Load, stand: Stand, tmp_path: Path) -> None:
    text = f"{HEAD}time_out_s: 7\n{CIRCLE}".replace(
        "goal: [shelf, home]", 'goal: [shelf, home]\nrounds: {most: 1, at: "12:00"}'
    )
    end, _ = run(load(text), stand, "11:59", tmp_path / "j")
    assert end.outcome == "Success"


class SlowDay(RehearsedDay):
    """A day whose clock runs at half the robot's speed."""

    @override
    def now(self) -> float:
        return super().now() - self._robot.time / 2.0


def test_a_wait_longer_than_expected_uses_up_no_time(load: Load, stand: Stand) -> None:
    task = load(f'{HEAD}time_out_s: 7\nrounds: {{most: 1, at: "12:00"}}\n{CIRCLE}')
    clock = SlowDay(stand.robot, time(11, 59, 51))
    assert stand.finish(Coordinator(task.network, stand.robot, stand.model, clock=clock)).outcome == "Success"


def test_interrupts_come_at_their_time_of_day(load: Load, stand: Stand, tmp_path: Path) -> None:
    text = f'interrupts: [{{name: last look, when: {{at: "23:59:59"}}, goal: door}}]\n{TWICE[len(HEAD) :]}'
    text = text.replace("09:00:12", "00:00:05").replace("09:00", "23:59:45")
    end, events = run(load(HEAD + text), stand, "23:59:45", tmp_path / "j")
    assert end.outcome == "Success"
    said = [event.words for event in events if isinstance(event, AimChanged)]
    assert said == ["round 2 begins at 00:00:05", "last look: first to door"]
    assert starts(tmp_path / "j")[2] == pytest.approx(14.0, abs=0.2)


def test_a_resumed_run_waits_on(load: Load, new_stand: Callable[[], Stand], tmp_path: Path) -> None:
    task, stand = load(TWICE), new_stand()
    run(task, stand, "08:59:57", tmp_path / "j")
    records = read_journal(tmp_path / "j").records
    waiting = next(n for n, record in enumerate(records) if record["kind"] == "AIM")
    again = new_stand()
    clock = RehearsedDay(again.robot, time(8, 59, 55))
    coordinator = Coordinator(
        task.network,
        again.robot,
        again.model,
        standing=standing(task.network, records[: waiting + 1]),
        clock=clock,
    )
    assert again.finish(coordinator).outcome == "Success"
    assert again.robot.time > 5.0 + 12.0


def test_a_resumed_round_that_began_does_not_wait_again(
    load: Load, new_stand: Callable[[], Stand], tmp_path: Path
) -> None:
    """The clock was set while the round waited; the program was killed after the round's first action."""
    task, stand = load(f'{HEAD}rounds: {{most: 1, at: "12:00"}}\n{CIRCLE}'), new_stand()
    noon = datetime(2026, 7, 1, 12).timestamp()
    day = LocalDay(
        lambda: stand.robot.time + (0.0 if stand.robot.time < 2.0 else noon - 5.0), lambda: stand.robot.time
    )
    with Journal(tmp_path / "j") as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": task.network.fingerprint()})
        stand.finish(Coordinator(task.network, stand.robot, stand.model, journal, clock=day))
    records = read_journal(tmp_path / "j").records
    killed = next(n for n, record in enumerate(records) if record["kind"] == "RESULT")
    position, again = standing(task.network, records[: killed + 1]), new_stand()
    assert position.round_began == pytest.approx(5.0, abs=0.2)
    clock = LocalDay(lambda: again.robot.time + noon + 60.0, lambda: again.robot.time)
    run = Coordinator(task.network, again.robot, again.model, standing=position, clock=clock).run()
    for _ in islice(run, 500):
        again.robot.step()
    assert next(run, "over") == "over"


@pytest.fixture
def berlin(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine in a time zone with summer time, by its rule alone, without a data base of zones."""
    monkeypatch.setenv("TZ", "CET-1CEST,M3.5.0,M10.5.0/3")
    clocks.tzset()
    yield
    monkeypatch.undo()
    clocks.tzset()


@pytest.mark.usefixtures("berlin")
@pytest.mark.parametrize(
    ("now", "hours"),
    [
        pytest.param(datetime(2026, 7, 1, 8, 0), 1.0, id="later the same day"),
        pytest.param(datetime(2026, 7, 1, 9, 0), 0.0, id="at that time"),
        pytest.param(datetime(2026, 7, 1, 10, 0), 23.0, id="the next day"),
        pytest.param(datetime(2026, 3, 28, 10, 0), 22.0, id="summer time begins in between"),
        pytest.param(datetime(2026, 10, 24, 10, 0), 24.0, id="summer time ends in between"),
    ],
)
def test_local_day_keeps_to_the_time_zone(now: datetime, hours: float) -> None:
    day = LocalDay(now.timestamp)
    due = day.next([time(9)], day.now())
    assert (due - day.now()) / 3600.0 == pytest.approx(hours)
    assert day.time_of_day(due) == time(9)


@pytest.mark.usefixtures("berlin")
@pytest.mark.parametrize("night", [datetime(2026, 3, 29), datetime(2026, 10, 25)])
def test_a_time_that_a_night_lacks_or_has_twice_comes_once(night: datetime) -> None:
    day = LocalDay(night.timestamp)
    first = day.next([time(2, 30)], day.now())
    second = day.next([time(2, 30)], after(first))
    assert (datetime.fromtimestamp(second).date() - night.date()).days == 1


def test_a_clock_that_is_set_starts_nothing(load: Load, stand: Stand) -> None:
    """A machine without a battery for its clock begins in 1970, and is set while the first round waits."""
    midnight = datetime(2026, 7, 1).timestamp()

    def wall() -> float:
        return stand.robot.time + (0.0 if stand.robot.time < 2.0 else midnight + 43_180.0)

    coordinator = Coordinator(
        *(load(f'{HEAD}rounds: {{most: 1, at: "12:00"}}\n{CIRCLE}').network, stand.robot, stand.model),
        clock=LocalDay(wall, lambda: stand.robot.time),
    )
    assert stand.finish(coordinator).outcome == "Success"
    assert stand.robot.time > 20.0


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ('rounds: {at: "9:00"}', "no time of day"),
        ('rounds: {at: "24:00"}', "no time of day"),
        ('rounds: {at: ["09:00", 5]}', "no time of day"),
        ("rounds: {at: []}", "at"),
        ("rounds: {at: 09:00}", "in quotes"),
        ('rounds: {at: "09:00", every_s: 5}', "has both every_s and at"),
        ('interrupts: [{name: a, when: {at: "09:00", every_s: 9}, goal: door}]', "needs one condition"),
    ],
)
def test_wrong_times_of_day_are_rejected(load: Load, key: str, words: str) -> None:
    with pytest.raises(FileError, match=words):
        load(f"{HEAD}{key}\n{CIRCLE}")


@pytest.mark.usefixtures("berlin")
def test_a_past_real_run_began_by_this_machines_clock() -> None:
    began = datetime(2026, 7, 1, 8, 30).timestamp()
    assert began_at({"wall": {"unix_s": began}}) == time(8, 30)
    assert began_at({"wall": {"unix_s": began}, "begins_at": "09:00:00"}) == time(9, 0)
    assert began_at({}) == time.min
