"""The way of hardware: drives that answer by themselves, and a wall clock."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from can.interfaces.virtual import VirtualBus

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bus.errors import CanFault, Emergency
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot

PERIOD = 0.1
BUS = {"interface": "virtual", "channel": "by themselves", "heartbeat_timeout_ms": 5000}


@pytest.fixture
def robot(cart: RobotFile, monkeypatch: pytest.MonkeyPatch) -> RobotFile:
    """Machines that tests run on may be busy."""
    monkeypatch.setattr("handcart.backends.live.pace.MAX_PERIOD_EXCESS_S", 30.0)
    monkeypatch.setattr("handcart.backends.live.pace.MAX_MISSED_PERIODS", 10_000)
    assert cart.can is not None
    spec = cart.can.model_copy(update=BUS)
    return cart.model_copy(update={"can": spec, "period_s": PERIOD})


@pytest.fixture
def bench(robot: RobotFile) -> Iterator[Bench]:
    with served(robot) as made:
        yield made


@contextmanager
def served(robot: RobotFile) -> Iterator[Bench]:
    """Drives in a thread of their own, on the bus that the robot's file names."""
    assert robot.can is not None
    made, end = Bench(robot, robot.can, None, VirtualBus("by themselves")), threading.Event()

    def serve() -> None:
        while not end.is_set():
            made.serve()
            time.sleep(0.0005)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield made
    finally:
        end.set()
        thread.join()
        made.close()


def test_a_step_lasts_a_period_and_the_wheels_roll(robot: RobotFile, bench: Bench) -> None:
    backend: Any
    with CanBackend(robot, None) as backend:
        assert backend.bench is None and backend.ground_truth() is None
        assert not backend.simulated
        base = backend.get(Base)
        backend.step()
        begin = time.monotonic()
        for _ in range(5):
            base.drive(0.2, 0.0)
            backend.step()
        assert 0.4 < time.monotonic() - begin < 5.0
        assert base.wheel_travel().left == pytest.approx(0.08, abs=0.03)
        assert base.wheel_travel().right == pytest.approx(base.wheel_travel().left, abs=0.01)
        assert backend.figures()["loop"]["periods"] == 6
    assert [drive.life.state for drive in bench.drives.values()] == ["SWITCH ON DISABLED"] * 2


def test_nothing_has_torque_before_the_first_step(robot: RobotFile, bench: Bench) -> None:
    with CanBackend(robot, None):
        time.sleep(2 * PERIOD)
        assert [drive.life.state for drive in bench.drives.values()] == ["SWITCH ON DISABLED"] * 2


def test_a_fault_that_a_frame_shows_is_not_waited_out(robot: RobotFile, bench: Bench) -> None:
    """C11: the stop leaves within the period, not at its end."""
    backend: Any
    with CanBackend(robot, None) as backend:
        backend.step()
        stopped, shown = list[float](), list[float]()
        backend._line.listen(
            lambda frame, ours: (
                stopped.append(time.monotonic()) if ours and frame.data[:1] == b"\x02" else None
            )
        )

        def show() -> None:
            time.sleep(0.2 * PERIOD)
            shown.append(time.monotonic())
            bench.line.send_message(0x081, b"\x10\x43\x01\x00\x00\x00\x00\x00")

        thread = threading.Thread(target=show)
        thread.start()
        with pytest.raises(Emergency):
            while True:
                backend.get(Base).drive(0.2, 0.0)
                backend.step()
        thread.join()
        assert 0.0 < stopped[0] - shown[0] < 0.7 * PERIOD
        with pytest.raises(CanFault):
            backend.step()


@pytest.mark.slow
def test_holding_joints_keep_their_torque_between_programs(robot: RobotFile) -> None:
    arm = load_robot("librarian")
    assert arm.can is not None
    spec = arm.can.model_copy(update=BUS)
    robot = arm.model_copy(update={"period_s": PERIOD, "can": spec})
    with served(robot) as bench:
        joints: list[Any] = [bench.drives[joint.node] for joint in spec.joints]
        backend: Any
        with CanBackend(robot, None) as backend:
            backend.step()
        assert {drive.life.state for drive in joints} == {"QUICK STOP ACTIVE"}
        states = []
        for drive in joints:
            drive.add_read_callback(lambda drive=drive, **_: states.append(drive.life.state))
        with CanBackend(robot, None) as backend:
            backend.step()
            backend.step()
        assert set(states) <= {"QUICK STOP ACTIVE", "OPERATION ENABLED"}
        assert "OPERATION ENABLED" in states


def test_looking_on_shows_how_drives_stop_by_themselves(robot: RobotFile, bench: Bench) -> None:
    """Drives that lose their torque or the heartbeat report it; `watch` waits all the same."""
    backend: Any
    with CanBackend(robot, None) as backend:
        backend.enable()
        for drive in bench.drives.values():
            drive.pressed = True
            drive.emcy.send(0x3120, 1)
        for _ in range(3):
            backend.watch()
        assert {axis.drive_state for axis in backend.axes.values()} == {"SWITCH ON DISABLED"}
        with pytest.raises(Emergency):
            backend.step()
