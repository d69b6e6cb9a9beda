"""Aims of a run that waits: for the battery's charge, for its next round, and for permission."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from pathlib import Path

import pytest
from typing_extensions import override

from handcart.backends.capabilities.battery import Battery
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator, Permission
from handcart.networks.events.run_end import RunEnd
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import Record, RunPosition, standing
from handcart.networks.operator.operation import Operation
from handcart.networks.operator.permits import Permits
from handcart.networks.task.task_file import Task
from handcart.robotics.geometry.pose2 import Pose2
from tests.networks.conftest import SPEC, Stand, TwoWheels

Load = Callable[..., Task]
HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\nstart: home\n"
MAP = """\
situations: {home: {}, desk: {}, dock: {}, door: {}, back: {}}
actions:
  - {do: DRIVE, from: home, to: desk, cost_s: 2, with: {periods: 20}}
  - {do: DRIVE, from: desk, to: back, cost_s: 2, with: {periods: 20}}
  - {do: THINK, from: desk, to: dock, cost_s: 2, attempts: 1, with: {name: dock}}
  - {do: DRIVE, from: dock, to: desk, cost_s: 2, with: {periods: 4}}
  - {do: DRIVE, from: dock, to: door, cost_s: 2, with: {periods: 4}}
  - {do: DRIVE, from: door, to: desk, cost_s: 2, with: {periods: 4}}
  - {do: THINK, from: home, to: door, cost_s: 2, attempts: 2, with: {name: door}}
"""


class Cell(Battery):
    """A battery with a charge that the test sets."""

    charge = 50.0

    @override
    def charge_percent(self) -> float:
        return self.charge


class Docking(TwoWheels):
    """Wheels, and a battery that is charged at the dock."""

    def __init__(self) -> None:
        super().__init__()
        self.cell = Cell()

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        return (*super().capabilities(), self.cell)


def run(
    task: Task,
    stand: Stand,
    path: Path,
    permission: Permission | None = None,
    position: RunPosition | None = None,
    low_at_s: float = 0.3,
    rate: float = 0.5,
) -> tuple[list[str], RunEnd, list[Record]]:
    """Run a task with a journal, and retrace each of its prefixes.

    The battery is at 15 % from `low_at_s` on. At the dock it rises by `rate` each period.

    Returns:
        The situations in which actions began, the end, and the journal's records.
    """
    backend = Docking()
    robot = Robot(backend, RobotFile.model_validate(SPEC), Pose2(0, 0, 0))
    with Journal(path) as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": task.network.fingerprint()})
        coordinator = Coordinator(
            task.network, robot, stand.model, journal, permission=permission, standing=position
        )
        periods = coordinator.run()
        end: RunEnd | None = None
        for _ in range(4000):
            try:
                next(periods)
            except StopIteration as ended:
                end = ended.value
                break
            robot.step()
            if robot.time > low_at_s:
                backend.cell.charge, low_at_s = 15.0, math.inf
            if coordinator.situation.startswith("dock") and coordinator.acting is None:
                backend.cell.charge += rate
    assert end is not None
    records: list[Record] = list(read_journal(path).records)
    if position is None:
        for count in range(1, len(records) + 1):
            standing(task.network, records[:count])
    starts = [record for record in records if record["kind"] == "START"]
    return [f"{record['action']['to']}" for record in starts], end, records


def at(records: list[Record], to: str) -> float:
    """Return when the last action to a situation began, in [s]."""
    return float(
        [record["t"] for record in records if record["kind"] == "START" and record["action"]["to"] == to][-1]
    )


LOW = "{name: low, when: {battery_below_percent: 20, until_percent: 80}, goal: dock, priority: 5}"


def test_charge_is_not_broken_off_by_lower_priorities(load: Load, stand: Stand, tmp_path: Path) -> None:
    look = "{name: look, when: {every_s: 4}, goal: door, priority: 1}"
    led, end, records = run(
        load(f"{HEAD}goal: back\ninterrupts: [{LOW}, {look}]\n{MAP}"), stand, tmp_path / "j"
    )
    assert led == ["desk", "dock", "desk", "dock", "door", "desk", "back"]
    starts = [record["t"] for record in records if record["kind"] == "START"]
    assert end.outcome == "Success"
    assert starts[2] - starts[1] > 6.0  # from 15 to 80 %, by 0.5 % each 0.05 s


def test_charge_goes_on_after_a_higher_interrupt(load: Load, stand: Stand, tmp_path: Path) -> None:
    look = "{name: look, when: {every_s: 4}, goal: door, priority: 9}"
    back = "  - {do: DRIVE, from: door, to: dock, cost_s: 1, with: {periods: 4}}\n"
    led, end, _ = run(
        load(f"{HEAD}goal: back\ninterrupts: [{LOW}, {look}]\n{MAP}{back}"), stand, tmp_path / "j"
    )
    assert led[:4] == ["desk", "dock", "door", "dock"]
    assert led[-2:] == ["desk", "back"]
    assert end.outcome == "Success"


def test_low_batteries_are_charged_in_the_next_round(load: Load, stand: Stand, tmp_path: Path) -> None:
    """In the first round, the only attempt to come to the dock fails."""
    text = f"{HEAD}goal: back\nrounds: 2\ninterrupts: [{LOW}]\n{MAP}"
    stand.script["dock"] = deque("F")
    led, end, _ = run(load(text), stand, tmp_path / "j")
    assert led == ["desk", "dock", "back", "desk", "dock", "desk", "back"]
    assert (end.outcome, end.fails) == ("Success", 1)


def test_charge_goes_on_when_the_run_is_resumed(load: Load, stand: Stand, tmp_path: Path) -> None:
    """Also above the limit at which the battery counts as low."""
    task = load(f"{HEAD}goal: back\ninterrupts: [{LOW}]\n{MAP}")
    _, _, records = run(task, stand, tmp_path / "j")
    docked = [record["kind"] for record in records].index("RESULT", 7) + 1
    position = standing(task.network, records[:docked])
    assert position.route.situation == "dock"
    led, _, resumed = run(task, stand, tmp_path / "again", position=position)
    assert led == ["desk", "back"]
    assert resumed[-1]["t"] > 3.5  # from 50 to 80 %
    assert standing(task.network, records).charging is None


def test_rounds_wait_though_an_interrupt_is_abandoned(load: Load, stand: Stand, tmp_path: Path) -> None:
    look = "{name: look, when: {every_s: 50}, goal: door}"
    one_door = MAP.replace("  - {do: DRIVE, from: dock, to: door, cost_s: 2, with: {periods: 4}}\n", "")
    text = f"{HEAD}goal: back\nrounds: {{most: 2, every_s: 60}}\ninterrupts: [{look}]\n{one_door}"
    stand.script["door"] = deque("FF")
    task = load(text)
    led, end, records = run(task, stand, tmp_path / "j", low_at_s=1e9)
    assert led == ["desk", "back", "door", "door", "desk", "back"]
    assert end.rounds == 2
    assert at(records, "desk") == pytest.approx(60.0, abs=0.1)
    kinds = [record["kind"] for record in records]
    last = len(kinds) - kinds[::-1].index("AIM") - 1
    waiting = [standing(task.network, records[:count]).round_waits for count in range(last, len(kinds))]
    assert not waiting[-1]


def test_time_outs_hold_while_permission_is_awaited(load: Load, stand: Stand, tmp_path: Path) -> None:
    text = f"{HEAD}goal: back\ntime_out_s: 9\notherwise: desk\n{MAP}"
    led, end, records = run(
        load(text), stand, tmp_path / "j", permission=lambda action: None if action.target == "back" else True
    )
    assert led == ["desk"]
    assert (end.outcome, end.otherwise) == ("Fail", "desk")
    assert end.reason.startswith("the task took longer than 9 s")
    assert 9.0 < records[-1]["t"] < 9.5


def test_interrupts_come_while_permission_is_awaited(load: Load, stand: Stand, tmp_path: Path) -> None:
    """The question is withdrawn, and asked again afterwards."""
    asked: list[str] = []

    def permission(action: object) -> bool | None:
        asked.append(str(action))
        return None if "back" in str(action) and len(asked) < 100 else True

    task = load(f"{HEAD}goal: back\ninterrupts: [{LOW}]\n{MAP}")
    led, end, _ = run(task, stand, tmp_path / "j", permission, low_at_s=3.0)
    assert led == ["desk", "dock", "desk", "back"]
    assert end.outcome == "Success"


def test_questions_are_withdrawn_when_the_time_is_over(load: Load, stand: Stand, tmp_path: Path) -> None:
    """An answer that comes too late must not permit the action when it is asked for again."""
    text = f"{HEAD}goal: back\ntime_out_s: 3\notherwise: desk\n{MAP}".replace(
        "to: back,", "to: back, permit: operator,"
    )
    permits = Permits()
    run = Coordinator(load(text).network, stand.robot, stand.model, permission=permits)
    periods = run.run()
    asked: list[bool] = []
    with Operation(tmp_path, run, permits, stand.robot) as operation, pytest.raises(StopIteration):
        while True:
            next(periods)
            stand.robot.step()
            operation.look()
            asked.append(operation.status()["asks"] is not None)
    assert any(asked)
    with Operation(tmp_path, run, permits, stand.robot) as operation:
        operation.look()
        assert operation.status()["asks"] is None
        assert operation.answer({"do": "permit"})["error"] == "no action waits for permission"
