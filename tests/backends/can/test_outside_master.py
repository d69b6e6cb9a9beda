"""The simulated drives obey a master that has nothing to do with ours: `canopen`'s `BaseNode402`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import canopen
import pytest

from handcart.backends.can.drives.drive_dictionary import drive_dictionary
from handcart.backends.can.simulated.simulated_drives import SimulatedDrives

NODE, PERIOD = 5, 0.01


@pytest.fixture
def drives() -> Iterator[SimulatedDrives]:
    """A drive that is served, and gets a SYNC each period, in a thread of its own."""
    made, end = SimulatedDrives([NODE], PERIOD), threading.Event()

    def serve() -> None:
        while not end.is_set():
            made.serve()
            made._on_sync()
            time.sleep(0.001)

    thread = threading.Thread(target=serve)
    thread.start()
    yield made
    end.set()
    thread.join()
    made.close()


@pytest.fixture
def master(drives: SimulatedDrives) -> Iterator[Any]:
    network = canopen.Network(drives.open())
    network.notifier = None
    network.connect()
    node: Any = canopen.BaseNode402(NODE, drive_dictionary(NODE))  # type: ignore[no-untyped-call]
    network.add_node(node)
    node.nmt.state = "PRE-OPERATIONAL"
    for index, value in (
        (0x6081, 20_000),
        (0x607F, 50_000),
        (0x6083, 100_000),
        (0x6084, 100_000),
        (0x6085, 400_000),
        (0x609A, 100_000),
    ):
        node.sdo[index].raw = value
    node.sdo[0x6099][1].raw = 20_000
    node.sdo[0x6099][2].raw = 4_000
    node.setup_402_state_machine()
    node.nmt.state = "OPERATIONAL"
    yield node
    network.disconnect()


def wait_for(done: Callable[[], Any], seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end
        time.sleep(0.002)


def test_it_is_brought_to_operation_enabled_and_stopped_quickly(drives: SimulatedDrives, master: Any) -> None:
    master.op_mode = "PROFILED VELOCITY"
    master.state = "OPERATION ENABLED"
    master.sdo[0x60FF].raw = 10_000
    drive = drives.nodes[NODE]
    wait_for(lambda: drive.velocity == pytest.approx(10_000))
    master.sdo[0x605A].raw = 6
    master.state = "QUICK STOP ACTIVE"
    wait_for(lambda: drive.velocity == 0.0)
    assert master.state == "QUICK STOP ACTIVE"  # and keeps its torque
    master.controlword = 0x0F  # transition 16
    wait_for(lambda: master.state == "OPERATION ENABLED")
    master.sdo[0x605A].raw = 2
    master.sdo[0x6040].raw = 0x02
    wait_for(lambda: master.state == "SWITCH ON DISABLED")


@pytest.mark.parametrize("method", [35, 37])
def test_it_is_homed_where_it_stands(drives: SimulatedDrives, master: Any, method: int) -> None:
    drives.nodes[NODE].stand_at(1234.0)
    master.sdo[0x6098].raw = method
    master.sdo[0x607C].raw = 50
    assert master.homing(timeout=10)
    assert master.sdo[0x6064].raw == 50


def test_it_is_homed_at_the_negative_limit_switch(drives: SimulatedDrives, master: Any) -> None:
    drive = drives.nodes[NODE]
    drive.demand.switch = -3000.0
    master.sdo[0x6098].raw = 17
    assert master.homing(timeout=20)
    wait_for(lambda: drive.velocity == 0.0)
    assert master.sdo[0x6064].raw == pytest.approx(drive.position + 3000.0, abs=1)
    assert -3000.0 < drive.position < -2800.0
    assert not master.sdo[0x60FD].raw & 1


def test_a_method_that_it_does_not_know_fails(drives: SimulatedDrives, master: Any) -> None:
    master.sdo[0x6098].raw = 1
    assert not master.homing(timeout=5)


def test_it_moves_in_profile_position_with_the_handshake(drives: SimulatedDrives, master: Any) -> None:
    drive = drives.nodes[NODE]
    master.op_mode = "PROFILED POSITION"
    master.state = "OPERATION ENABLED"
    target = master.rpdo_pointers[0x607A]  # goes out with the controlword
    target.raw = 3000
    master.controlword = 0x1F  # a new set-point
    wait_for(lambda: master.statusword & 0x1000)  # taken
    assert not master.statusword & 0x0400
    target.raw = 1000
    master.controlword = 0x0F
    master.controlword = 0x1F  # one more: waits until the first is reached
    target.raw = -500
    master.controlword = 0x0F
    wait_for(lambda: drive.position == 1000.0)
    assert master.sdo[0x6064].raw == 1000
    wait_for(lambda: master.statusword & 0x0400)
    master.controlword = 0x3F  # at once
    wait_for(lambda: drive.position == -500.0)
    master.controlword = 0x0F
    target.raw = 200
    master.controlword = 0x7F  # at once, relative
    wait_for(lambda: drive.position == -300.0)


def test_a_fault_is_reset(drives: SimulatedDrives, master: Any) -> None:
    drive = drives.nodes[NODE]
    master.op_mode = "PROFILED VELOCITY"
    master.state = "OPERATION ENABLED"
    drive.fail(0x2310)
    wait_for(master.is_faulted)
    assert master.sdo[0x603F].raw == 0x2310
    assert master.emcy.active[-1].code == 0x2310
    master.controlword = 0x00
    master.controlword = 0x80
    wait_for(lambda: not master.is_faulted())
    assert master.sdo[0x603F].raw == 0
    master.state = "OPERATION ENABLED"
    assert drive.life.state == "OPERATION ENABLED"
