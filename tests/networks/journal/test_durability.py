"""Records that must be on the disk before anything moves, or observers are notified (rows D6, D8, D9)."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import ClassVar

import pytest

from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.events import Ended, Event, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalError, read_journal
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from tests.networks.conftest import Stand

Begin = Callable[[], tuple[Coordinator, Journal, list[Event]]]


class Lamp(ActionPrimitive):
    """Drives on, then puts a lamp out: that can't be done twice, nor undone."""

    needs: ClassVar = (Base,)
    put_out: ClassVar[list[float]] = []

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(5):
            robot.base.drive(0.2, 0.0)
            yield
        yield from self.intend("the lamp goes out")
        self.put_out.append(robot.time)
        self.point_of_no_return("the lamp is out")
        yield


class Disk:
    """A disk that can be held up, or broken."""

    def __init__(self) -> None:
        self.calls = 0
        self.free = threading.Event()
        self.free.set()
        self.broken = False

    def fdatasync(self, _file: int) -> None:
        self.calls += 1
        assert self.free.wait(20.0)
        if self.broken:
            raise OSError(5, "Input/output error")


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Disk]:
    held = Disk()
    monkeypatch.setattr(os, "fdatasync", held.fdatasync)
    monkeypatch.setattr(Lamp, "put_out", [])
    yield held
    held.free.set()


@pytest.fixture
def begin(stand: Stand, disk: Disk, tmp_path: Path) -> Begin:
    """A run with one action, its journal brought to the disk beside the loop."""

    def make() -> tuple[Coordinator, Journal, list[Event]]:
        bound = Binding.of(Lamp())
        network = ActionNetwork.build(
            [Situation("a"), Situation("z")], [Action("a", "z", bound, 1.0)], "a", "z"
        )
        journal = Journal(tmp_path / "j", "beside")
        events: list[Event] = []
        run = Coordinator(network, stand.robot, stand.model, journal, observers=[events.append])
        return run, journal, events

    return make


def go_on(stand: Stand, periods: Generator[None, None, RunEnd], count: int) -> None:
    for _ in range(count):
        next(periods)
        stand.robot.step()


def has(events: list[Event], kind: type[Event]) -> bool:
    return any(isinstance(event, kind) for event in events)


def soon(
    disk: Disk, stand: Stand, periods: Generator[None, None, RunEnd], ready: Callable[[], object]
) -> None:
    """Let the disk work until something is so."""
    disk.free.set()
    end = time.monotonic() + 20.0
    while not ready():
        assert time.monotonic() < end
        go_on(stand, periods, 1)
        time.sleep(0.001)


def test_nothing_moves_before_the_start_is_on_the_disk(stand: Stand, disk: Disk, begin: Begin) -> None:
    """D9: the loop continues, the robot holds; a slow disk only delays."""
    run, journal, events = begin()
    with journal:
        disk.free.clear()
        periods = run.run()
        go_on(stand, periods, 100)
        assert has(events, Started)
        assert stand.backend.wheels.travel == WheelTravel(0.0, 0.0)
        soon(disk, stand, periods, lambda: stand.backend.wheels.travel.left > 0.0)


def test_an_effect_waits_for_its_intent_and_the_result_for_the_disk(
    stand: Stand, disk: Disk, begin: Begin
) -> None:
    """D9: no observer receives an outcome that is not on the disk."""
    run, journal, events = begin()
    with journal:
        periods = run.run()
        soon(disk, stand, periods, lambda: stand.backend.wheels.travel.left > 0.0)
        while not journal.durable:
            time.sleep(0.001)
        disk.free.clear()
        go_on(stand, periods, 60)
        assert Lamp.put_out == []
        soon(disk, stand, periods, lambda: Lamp.put_out)
        while not journal.durable:
            time.sleep(0.001)
        disk.free.clear()
        go_on(stand, periods, 60)
        kinds = [record["kind"] for record in read_journal(journal.path).records]
        assert kinds == ["PLAN", "START", "INTENT", "PNR", "RESULT"]
        assert not has(events, Ended)
        with pytest.raises(StopIteration):
            soon(disk, stand, periods, lambda: False)
        assert has(events, Ended)


def test_a_stop_does_not_wait_for_the_disk(stand: Stand, disk: Disk, begin: Begin) -> None:
    """D9: neither before the start nor while a result waits."""
    run, journal, _ = begin()
    disk.free.clear()
    periods = run.run()
    go_on(stand, periods, 10)
    run.request(Request.STOP)
    stops = stand.backend.stops
    go_on(stand, periods, 3)
    assert stand.backend.stops > stops
    disk.free.set()
    journal.close()


def test_a_disk_that_fails_ends_the_run_and_is_never_asked_again(
    stand: Stand, disk: Disk, begin: Begin
) -> None:
    """D8: the journal is poisoned; nothing was commanded."""
    run, journal, _ = begin()
    with journal:
        disk.broken = True
        periods = run.run()
        with pytest.raises(JournalError, match="Input/output"):
            for _ in range(2000):
                go_on(stand, periods, 1)
                time.sleep(0.001)
        assert disk.calls == 1
        assert stand.backend.wheels.travel == WheelTravel(0.0, 0.0)
        with pytest.raises(JournalError):
            journal.append("MORE", 0.0, {})
        assert disk.calls == 1


def test_what_was_intended_stands_in_the_journal(
    stand: Stand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """INTENT and PNR name the action and what it does."""
    monkeypatch.setattr(Lamp, "put_out", [])
    bound = Binding.of(Lamp())
    network = ActionNetwork.build([Situation("a"), Situation("z")], [Action("a", "z", bound, 1.0)], "a", "z")
    with Journal(tmp_path / "j") as journal:
        stand.finish(Coordinator(network, stand.robot, stand.model, journal))
    records = read_journal(tmp_path / "j").records
    by_kind = {record["kind"]: record for record in records}
    assert (by_kind["INTENT"]["n"], by_kind["INTENT"]["effect"]) == (1, "the lamp goes out")
    assert (by_kind["PNR"]["n"], by_kind["PNR"]["what"]) == (1, "the lamp is out")
    assert by_kind["START"]["at"]["base"] == [0.0, 0.0, 0.0]
    assert by_kind["RESULT"]["at"]["base"][0] == pytest.approx(0.05)
    assert by_kind["END"]["at"] == by_kind["RESULT"]["at"]


def test_a_run_is_over_when_its_end_is_on_the_disk(stand: Stand, disk: Disk, begin: Begin) -> None:
    """D9: a reported end cannot be lost in a crash."""
    run, journal, events = begin()
    with journal:
        periods = run.run()
        soon(disk, stand, periods, lambda: Lamp.put_out)
        while not has(events, Ended):
            disk.free.set()
            while not journal.durable:
                time.sleep(0.001)
            disk.free.clear()
            go_on(stand, periods, 1)
        go_on(stand, periods, 100)
        assert [record["kind"] for record in read_journal(journal.path).records][-1] == "END"
        with pytest.raises(StopIteration):
            soon(disk, stand, periods, lambda: False)
