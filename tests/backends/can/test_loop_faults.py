"""A control loop that hangs, is late, or whose clock jumps, each by the row of docs/reference/faults.md."""

from __future__ import annotations

import time

import pytest

from handcart.backends.can.bus.errors import CanFault, LateLoop
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile

from .conftest import Make
from .faulty import BEFORE, assert_drives_stop_alone, assert_stopped, move


def test_a_loop_that_hangs_is_silent_and_the_drives_stop(make: Make, robot: RobotFile) -> None:
    """C8 K4 K14: the heartbeat is sent by the loop; when it hangs, or is killed, the drives stop alone."""
    backend = make(robot=robot, room=False)
    move(backend, 20)
    assert_drives_stop_alone(backend)
    with pytest.raises(CanFault):  # and when it wakes up, it gives up
        move(backend, 1)


def test_drives_stop_without_heartbeat_despite_commands(make: Make, robot: RobotFile) -> None:
    """C8: 1016h is a watch of its own."""
    backend = make(robot=robot, room=False)
    move(backend, 20)
    assert robot.can is not None
    send, ours = backend.bench.master.send, 0x700 + robot.can.our_node
    backend.bench.master.send = lambda frame, timeout=None: (
        None if frame.arbitration_id == ours else send(frame, timeout)
    )
    with pytest.raises(CanFault):
        move(backend, 2 + round(robot.can.heartbeat_timeout_ms / 1e3 / backend.period))
    assert "OPERATION ENABLED" not in {drive.life.state for drive in backend.bench.drives.values()}


def test_a_late_loop_ramps_to_a_stop(make: Make, robot: RobotFile) -> None:
    """K6 K7 K9: three periods missed in a row, or one gap of 50 ms."""

    class Late:
        trouble = ""

        def wait(self) -> None:
            return

        def begin(self) -> None:
            return

    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    backend._pace = Late()
    move(backend, 2)
    backend._pace.trouble = "a period ended 63 ms late; allowed: 50 ms"
    with pytest.raises(LateLoop, match="the control loop is too slow: a period ended 63 ms late") as raised:
        move(backend, 1)
    assert_stopped(backend, raised.value)


def test_wall_clocks_are_not_asked(make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch) -> None:
    """K8 B9: a clock that jumps by an hour changes nothing; on a bench no clock is read."""
    moments = iter(range(0, 10**9, 3600))
    for name in ("time", "monotonic"):
        monkeypatch.setattr(time, name, lambda: float(next(moments)))
    backend = make(robot=robot, room=False)
    move(backend, 20)
    assert backend.get(Base).wheel_travel().left > 0.1
