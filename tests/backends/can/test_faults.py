"""What goes wrong on the bus."""

from __future__ import annotations

import can
import pytest

from backends.base import Base
from backends.can.can_line import CanLine
from backends.can.errors import BusFault, DriveNotReady, NoInterface, SilentDrive, WrongDrive

from .conftest import LEFT, RIGHT


def drive(backend, periods):
    for _ in range(periods):
        backend.get(Base).drive(0.5, 0.0)
        backend.step()


def assert_stopped(backend, fault):
    """Both wheels, for good."""
    nodes = backend.bench.drives.values()
    assert [node.velocity for node in nodes] == [0.0, 0.0]
    assert all(node.life.state in ("SWITCH ON DISABLED", "FAULT") for node in nodes)
    there = [node.position for node in nodes]
    with pytest.raises(type(fault)) as again:
        drive(backend, 1)
    backend.stop()
    backend.close()
    assert again.value is fault
    assert [node.position for node in nodes] == there


def test_a_silent_drive_ends_the_step_and_stops_both(make):
    backend = make()
    drive(backend, 20)
    backend.bench.drives[RIGHT].silent = True
    with pytest.raises(SilentDrive, match=r"the right drive \(node 2\) is silent") as told:
        drive(backend, 1)
    assert "statusword and position (6041h, 6064h)" in str(told.value)
    assert str(told.value).endswith("for 0.05 s")
    assert isinstance(told.value, TimeoutError)
    assert_stopped(backend, told.value)


def test_a_faulted_drive_ends_the_step_and_stops_both(make):
    backend = make()
    drive(backend, 20)
    before = backend.scene.base.y
    backend.bench.drives[LEFT].fail(0x8611)
    with pytest.raises(DriveNotReady) as told:
        drive(backend, 1)
    assert str(told.value) == (
        "the left drive (node 1) is in the state FAULT REACTION ACTIVE: error 8611h, following error; "
        "needed: OPERATION ENABLED"
    )
    assert backend.scene.base.y > before + 0.03  # braking takes its way, in truth too
    assert_stopped(backend, told.value)


def test_a_drive_that_somebody_disables_ends_the_step(make):
    backend = make()
    backend.bench.drives[LEFT].life.disable()
    with pytest.raises(DriveNotReady, match="SWITCH ON DISABLED; needed") as told:
        drive(backend, 1)
    assert_stopped(backend, told.value)


def test_a_drive_in_another_mode_ends_the_step(make):
    backend = make()
    drive(backend, 20)
    backend._wheels.left.sdo[0x6060].raw = 1
    with pytest.raises(DriveNotReady, match="in the mode 1") as told:
        drive(backend, 1)
    assert_stopped(backend, told.value)


def test_a_bus_that_fails_is_told(make, monkeypatch):
    backend = make()

    def fail(*_, **__):
        raise can.CanOperationError("bus off")

    monkeypatch.setattr(backend._line.bus, "send", fail)
    with pytest.raises(BusFault, match="while driving: bus off"):
        drive(backend, 1)


def test_a_fault_ends_a_command_with_status_5_and_without_a_traceback(make, monkeypatch, capsys):
    from backends.can.can_backend import CanBackend
    from tools.handcart import main

    step, count = CanBackend.step, iter(range(10**6))

    def fails(self):
        if next(count) == 30:
            self.bench.drives[LEFT].silent = True
        step(self)

    monkeypatch.setattr(CanBackend, "step", fails)
    with pytest.raises(SystemExit) as end:
        main(["do", "MOVE_TO", "place=shelf_3", "--robot", "cart", "--backend", "can"])
    assert end.value.code == 5
    assert "the left drive (node 1) is silent" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("index", "value", "error", "told"),
    [
        (0x1000, 0x191, WrongDrive, r"device profile \(1000h\) is 401; allowed: 402"),
        (0x6502, 0x01, WrongDrive, r"drive modes \(6502h\) is 0x1; allowed: profile velocity"),
        (0x6083, 7, WrongDrive, r"profile acceleration \(6083h\) is 7; allowed: the \d+ that was written"),
    ],
)
def test_a_drive_that_is_none_is_told(make, monkeypatch, index, value, error, told):
    from backends.can.simulated.drive_node import DriveNode

    plain = DriveNode._value
    monkeypatch.setattr(DriveNode, "_value", lambda self, i: value if i == index else plain(self, i))
    with pytest.raises(error, match=told):
        make()


def test_a_missing_drive_is_told(make, monkeypatch):
    from backends.can.simulated.simulated_drives import SimulatedDrives

    plain = SimulatedDrives.__init__
    monkeypatch.setattr(SimulatedDrives, "__init__", lambda self, *nodes: plain(self, nodes[0]))
    with pytest.raises(SilentDrive, match=r"the right drive \(node 2\) is silent: no answer to an SDO"):
        make()


def test_an_interface_that_cannot_be_opened_is_told(make, cart):
    spec = cart.can.model_copy(update={"interface": "socketcan", "channel": "no_such0"})
    with pytest.raises(NoInterface, match=r"no CAN on socketcan no_such0: .*ip link set no_such0"):
        make(robot=cart.model_copy(update={"can": spec}))


def test_a_line_waits_no_longer_than_told():
    with can.interfaces.virtual.VirtualBus("quiet") as bus, can.interfaces.virtual.VirtualBus("quiet") as far:
        line, seen = CanLine(bus), []
        line.subscribe(0x181, lambda *frame: seen.append(frame[1]))
        assert not line.wait(lambda: bool(seen), 0.01)
        far.send(can.Message(arbitration_id=0x181, data=[1], is_extended_id=True))  # not CANopen
        far.send(can.Message(arbitration_id=0x181, data=[2], is_extended_id=False))
        assert line.wait(lambda: bool(seen), 1.0)
        assert seen == [b"\x02"]
