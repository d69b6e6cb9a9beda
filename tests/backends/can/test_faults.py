"""Faults of the bus before anything moves, and their effect on commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import can
import pytest

from handcart.backends.backend import NoBench
from handcart.backends.can.bench.injected_faults import UnknownFault, inject
from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.errors import (
    BusFault,
    DriveNotReady,
    NoInterface,
    ReadBackDiffers,
    SilentDrive,
    TwoNodes,
    WrongDrive,
)
from handcart.backends.can.simulated.drive_node import DriveNode
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend

from .conftest import LEFT, RIGHT, Make


def drive(backend: Any, periods: int) -> None:
    for _ in range(periods):
        backend.get(Base).drive(0.5, 0.0)
        backend.step()


def test_a_drive_that_has_a_fault_is_not_reset(make: Make) -> None:
    backend = make()
    backend.bench.drives[LEFT].fail(0x8611)
    backend.bench.tick(0.05)
    with pytest.raises(
        DriveNotReady, match=r"the left wheel drive \(node 1\) is in the state FAULT: error 8611h"
    ):
        drive(backend, 1)
    assert backend.bench.drives[LEFT].life.state == "FAULT"


def test_if_one_drive_is_not_ready_none_stays_enabled(make: Make) -> None:
    robot = load_robot("librarian")
    backend = make(robot=robot, room=False)
    drives = backend.bench.drives
    control = drives[21].life.control
    drives[21].life.control = lambda word: None if word == 0x0F else control(word)
    with pytest.raises(DriveNotReady, match=r"the gripper drive \(node 21\) is in the state SWITCHED ON"):
        drive(backend, 1)
    assert drives[LEFT].life.state == "SWITCH ON DISABLED"
    assert drives[11].life.state == "QUICK STOP ACTIVE"  # it would fall


def test_a_drive_in_another_mode_ends_the_step(make: Make) -> None:
    backend = make()
    drive(backend, 20)
    backend.axes["left wheel"].sdo[0x6060].raw = 1
    with pytest.raises(DriveNotReady, match="in the mode 1"):
        drive(backend, 1)


def test_a_bus_that_fails_is_told(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    backend = make()
    drive(backend, 1)

    def fail(*_: object, **__: object) -> None:
        raise can.CanOperationError("bus off")

    monkeypatch.setattr(backend.bench.master, "send", fail)
    with pytest.raises(BusFault, match="while driving: bus off"):
        drive(backend, 1)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "do"])
def test_a_fault_ends_a_command_with_status_4_and_without_a_traceback(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A person has to look: GiveUp, with the reason in words."""
    from handcart.backends.can.can_backend import CanBackend
    from handcart.tools.main import main

    step, count = CanBackend.step, iter(range(10**6))

    def fails(self: Any) -> None:
        if next(count) == 30:
            inject(self.bench, "silent")
        step(self)

    monkeypatch.setattr(CanBackend, "step", fails)
    run = ["run", "tasks/drive_map/task.yaml", "--no-sync", "--runs", str(tmp_path)]
    do = ["do", "MOVE_TO", "place=shelf_3"]
    with pytest.raises(SystemExit) as end:
        main([*(run if command == "run" else do), "--robot", "cart", "--backend", "can"])
    assert end.value.code == 4
    printed = capsys.readouterr()
    assert "the left wheel drive (node 1) is silent" in printed.out + printed.err
    assert "Traceback" not in printed.err
    assert ("GiveUp in situation" in printed.out) == (command == "run")


@pytest.mark.parametrize(
    ("index", "value", "error", "message"),
    [
        (0x1000, 0x191, WrongDrive, r"device profile \(1000h\) is 401; allowed: 402"),
        (0x6502, 0x01, WrongDrive, r"drive modes \(6502h\) is 0x1; allowed: profiled velocity"),
    ],
)
def test_a_drive_that_is_none_is_told(
    make: Make, monkeypatch: pytest.MonkeyPatch, index: int, value: int, error: type[WrongDrive], message: str
) -> None:
    plain = DriveNode._value
    monkeypatch.setattr(DriveNode, "_value", lambda self, i: value if i == index else plain(self, i))
    with pytest.raises(error, match=message):
        make()


def test_settings_that_differ_are_told_all_at_once(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = DriveNode._power_on

    def stubborn(self: DriveNode) -> None:
        plain(self)
        self.wrong.keeps = {(0x6083, 0): 7, (0x1017, 0): 0}

    monkeypatch.setattr(DriveNode, "_power_on", stubborn)
    monkeypatch.setattr(DriveNode, "__init__", _early(DriveNode.__init__))
    with pytest.raises(ReadBackDiffers) as raised:
        make()
    lines = str(raised.value).splitlines()
    assert len(lines) == len(raised.value.differences) == 4
    assert lines[0] == "the left wheel drive (node 1): producer heartbeat time (1017h) is 0; wanted: 50"
    assert lines[3].startswith("the right wheel drive (node 2): profile acceleration (6083h) is 7; wanted: ")


def _early(init: Callable[..., None]) -> Callable[..., None]:
    """What a drive does wrong has to be there before it boots."""
    from handcart.backends.can.simulated.drive_faults import DriveFaults

    def made(self: DriveNode, *given: Any) -> None:
        self.wrong = DriveFaults()
        init(self, *given)

    return made


def test_an_identity_that_is_not_the_files_is_told(make: Make, cart: RobotFile) -> None:
    assert cart.can is not None
    left = cart.can.left.model_copy(update={"vendor_id": 0x2E})
    robot = cart.model_copy(update={"can": cart.can.model_copy(update={"left": left})})
    with pytest.raises(WrongDrive, match=r"vendor-ID \(1018h:1\) is 0x0; allowed: 0x2e"):
        make(robot=robot)


def test_a_missing_drive_is_told(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """C14: no answer to an SDO, tried twice."""
    from handcart.backends.can.bench import bench
    from handcart.backends.can.simulated.simulated_drives import SimulatedDrives

    plain = SimulatedDrives
    monkeypatch.setattr(bench, "SimulatedDrives", lambda nodes, *rest: plain(nodes[:1], *rest))
    with pytest.raises(SilentDrive, match=r"the right wheel drive \(node 2\) is silent: no answer to an SDO"):
        make(room=False)


def test_two_drives_with_one_node_id_are_told_before_anything_moves(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """C15: both answer."""
    from handcart.backends.can.bench import bench
    from handcart.backends.can.simulated.simulated_drives import SimulatedDrives

    class Twice(SimulatedDrives):
        def __init__(self, nodes: Sequence[int], *rest: Any) -> None:
            super().__init__(nodes, *rest)
            self._double = CanLine(self.open())
            self._double[RIGHT] = DriveNode(RIGHT)

        def serve(self) -> None:
            super().serve()
            self._double.drain()

        def close(self) -> None:
            super().close()
            self._double.close()

    monkeypatch.setattr(bench, "SimulatedDrives", Twice)
    with pytest.raises(TwoNodes, match=r"two nodes seem to be the right wheel drive \(node 2\): two answers"):
        make(room=False)


def test_an_interface_that_cannot_be_opened_is_told(cart: RobotFile) -> None:
    """C1: with the line that brings it up."""
    assert cart.can is not None
    spec = cart.can.model_copy(update={"interface": "socketcan", "channel": "no_such0"})
    with pytest.raises(NoInterface, match=r"no CAN on socketcan no_such0: .*ip link set no_such0"):
        make_backend("can", cart.model_copy(update={"can": spec}), None, 0)


def test_a_line_waits_no_longer_than_told() -> None:
    with can.interfaces.virtual.VirtualBus("quiet") as bus, can.interfaces.virtual.VirtualBus("quiet") as far:
        line, seen = CanLine(bus), []
        line.subscribe(0x181, lambda *frame: seen.append(frame[1]))
        assert not line.wait(lambda: bool(seen), 0.01)
        far.send(can.Message(arbitration_id=0x181, data=[1], is_extended_id=True))  # not CANopen
        far.send(can.Message(arbitration_id=0x181, data=[2], is_extended_id=False))
        assert line.wait(lambda: bool(seen), 1.0)
        assert seen == [b"\x02"]
        assert line.malformed == 1


def test_a_late_line_still_receives_what_has_arrived() -> None:
    """A process that was held up for longer than the time-out finds the answer at the interface."""
    with can.interfaces.virtual.VirtualBus("late") as bus, can.interfaces.virtual.VirtualBus("late") as far:
        line, seen = CanLine(bus), []
        line.subscribe(0x181, lambda *frame: seen.append(frame[1]))
        for value in (1, 2):
            far.send(can.Message(arbitration_id=0x181, data=[value], is_extended_id=False))
        assert line.wait(lambda: len(seen) == 2, 0.0)
        assert seen == [b"\x01", b"\x02"]


@pytest.mark.parametrize(
    ("backend", "bench", "message"),
    [
        ("kinematic", "kinematic", "the backend 'kinematic' has no drives; allowed"),
        ("can", "can", "the backend 'can' simulates no robot"),
        (
            "can",
            "kinematik",
            "unknown bench 'kinematik'; did you mean 'kinematic'? allowed: kinematic",
        ),
    ],
)
def test_a_bench_that_cannot_be_is_refused_with_status_2(
    backend: str, bench: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from handcart.tools.main import main

    with pytest.raises(SystemExit) as end:
        main(["run", "tasks/return_book/task.yaml", "--backend", backend, "--bench", bench])
    assert end.value.code == 2
    assert message in capsys.readouterr().err


def test_a_fault_that_nobody_knows_is_refused(make: Make) -> None:
    with pytest.raises(UnknownFault, match="did you mean 'reversed'"):
        inject(make().bench, "reverse")


def test_without_a_bench_the_capabilities_are_known_unbuilt() -> None:
    from handcart.backends.can.can_backend import CanBackend

    kinds = CanBackend.kinds(load_robot("librarian"))
    assert kinds is not None
    assert [kind.__name__ for kind in kinds] == ["Base", "ForceArm", "Gripper"]
    assert NoBench.exit_status == 2
