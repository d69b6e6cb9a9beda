"""Faults of the bus and the interface, each by its row of docs/reference/faults.md."""

from __future__ import annotations

from typing import Any

import can
import numpy as np
import pytest

from handcart.backends.can.bus.errors import (
    BusFault,
    CanFault,
    ControllerFault,
    Overloaded,
    QueueFull,
    SilentDrive,
)
from handcart.backends.description.robot_file import RobotFile
from tests.backends.can.cable import plug_in

from .conftest import Make
from .faulty import BEFORE, assert_drives_stop_alone, assert_told, fault_of, move


def test_drives_stop_by_themselves_when_the_interface_goes_down(make: Make, robot: RobotFile) -> None:
    """C2: our heartbeat is missing, so they stop by 6007h within 150 ms and their ramp."""
    backend = make(robot=robot, room=False)
    fault = fault_of(backend, "bus-down")
    assert isinstance(fault, BusFault)
    assert "Network is down" in str(fault)
    assert_drives_stop_alone(backend)


def test_a_warning_of_the_controller_is_waited_out_for_a_second(make: Make, robot: RobotFile) -> None:
    """C3: at warning for 1 s."""
    backend = make(robot=robot, room=False)
    start = backend.bench.time
    fault = fault_of(backend, "error-warning", within=40)
    assert_told("in warning for 1 s", fault)
    assert backend.bench.time - start > 1.0


def test_what_the_interface_says_of_itself_is_heard(make: Make, robot: RobotFile) -> None:
    """C3 C4: interfaces without error frames."""
    for state, message in ((can.BusState.PASSIVE, "error-passive"), (can.BusState.ERROR, "bus-off")):
        backend = make(robot=robot, room=False)
        move(backend, 2)
        backend.bench.master.condition = state
        with pytest.raises(ControllerFault, match=message):
            move(backend, 1)


def test_one_lost_frame_is_tolerated_and_three_stop_the_robot(make: Make, robot: RobotFile) -> None:
    """C5: as lost set-points."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    send, refused = backend.bench.master.send, list[can.Message]()

    def once(frame: can.Message, timeout: float | None = None) -> None:
        if frame.arbitration_id == 0x201 and not refused:
            refused.append(frame)
            raise can.CanOperationError("Transmit buffer full")
        send(frame, timeout)

    backend.bench.master.send = once
    move(backend, BEFORE)
    assert refused
    fault = fault_of(backend, "queue-full")
    assert isinstance(fault, QueueFull)
    assert "3 frames in a row" in str(fault)


def commands(bus: Any) -> list[can.Message]:
    """Return the set-points in the interface's queue: for wheels those of a speed."""
    return [
        frame
        for frame in bus.held
        if 0x200 < frame.arbitration_id < 0x280 and frame.data[0] & 0x0F == 0x0F and any(frame.data[2:])
    ]


@pytest.mark.parametrize("flushes", [True, False])
def test_what_was_queued_moves_nothing_when_the_cable_is_back(
    make: Make, robot: RobotFile, flushes: bool
) -> None:
    """C6: frames in the interface are thrown away; if that is impossible, the drives don't accept them."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    bus, drives = backend.bench.master, backend.bench.drives
    bus.holds = True
    if not flushes:
        bus.flush_tx_buffer = lambda: None
    move(backend, 1)
    assert len(commands(bus)) >= 2  # both wheels'
    with pytest.raises(SilentDrive) as first:
        move(backend, 10)
    assert bool(commands(bus)) is not flushes
    for _ in range(60):
        backend.bench.tick(0.05)  # the drives miss our heartbeat meanwhile
    there = [drive.position for drive in drives.values()]
    plug_in(bus)
    for _ in range(20):
        backend.bench.serve()
        backend.bench.tick(0.05)
    assert [drive.position for drive in drives.values()] == there
    assert "OPERATION ENABLED" not in {drive.life.state for drive in drives.values()}
    with pytest.raises(CanFault) as again:
        backend.step()
    assert again.value is first.value


def test_a_stop_throws_away_what_is_queued(make: Make, robot: RobotFile) -> None:
    """C6: on any stop, not at the end alone."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    bus = backend.bench.master
    bus.holds = True
    move(backend, 1)
    assert commands(bus)
    backend.stop()
    wheels = [frame for frame in commands(bus) if frame.arbitration_id in (0x201, 0x202)]
    assert wheels == []
    assert [frame for frame in bus.held if frame.arbitration_id in (0x201, 0x202)]  # commands standstill


def test_what_is_queued_stays_what_it_was(make: Make) -> None:
    """C6: each set-point is a frame of its own, though they are made in one buffer."""
    backend = make(room=False)
    backend.step()
    bus = backend.bench.master
    bus.holds = True
    for speed in (0.1, 0.2):
        backend.axes.left.command(speed)
        backend.axes.left.send()
    commands = [bytes(frame.data) for frame in bus.held if frame.arbitration_id == 0x201]
    assert len(commands) == len(set(commands)) == 2


def test_random_frames_raise_nothing_but_a_count(make: Make, robot: RobotFile) -> None:
    """C20 C21: the decoder takes anything; what a listener raises doesn't deafen the robot."""
    backend = make(robot=robot, room=False)
    move(backend, 1)
    rng = np.random.default_rng(8)
    line = backend._line
    kinds = rng.integers(0, 40, 20_000)
    for kind, can_id, length, data in zip(
        kinds,
        rng.integers(0, 0x800, 20_000),
        rng.integers(0, 9, 20_000),
        rng.integers(0, 256, (20_000, 8), dtype=np.uint8),
        strict=True,
    ):
        line._take(
            can.Message(
                arbitration_id=int(can_id),
                data=None if kind == 0 else data[:length].tobytes(),
                is_remote_frame=kind == 0,
                is_error_frame=kind == 1,
                is_extended_id=kind == 2,
                is_fd=kind == 3,
            )
        )
    assert line.malformed > 100
    with pytest.raises(CanFault):
        move(backend, 1)


def test_raising_listener_is_counted_and_the_next_frame_is_received(make: Make, robot: RobotFile) -> None:
    """C21: there is no receive thread that could die."""
    backend = make(robot=robot, room=False)
    move(backend, 1)

    def raises(*_: object) -> None:
        raise RuntimeError("a listener")

    backend._line.subscribe(0x181, raises)
    move(backend, 2)
    assert backend._line.malformed == 2
    with pytest.raises(
        Overloaded, match=r"malformed.*; the last: 181h, [0-8] bytes: RuntimeError: a listener"
    ):
        move(backend, 10)
