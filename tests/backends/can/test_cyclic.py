"""Cyclic synchronous modes: the set-points are ours, the drive goes from SYNC to SYNC."""

from __future__ import annotations

from typing import Any

import can
import numpy as np
import pytest

from handcart.backends.can.bench.bench_bus import BenchBus
from handcart.backends.can.bus.errors import CanFault, ReadBackDiffers
from handcart.backends.can.drives.axis_settings import interpolation_time
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot

from .conftest import Make

JOINT_1 = 11
TURN = np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0])


@pytest.fixture
def robot() -> RobotFile:
    robot = load_robot("librarian")
    assert robot.can is not None
    joints = tuple(joint.model_copy(update={"mode": "csp"}) for joint in robot.can.joints)
    wheels = {side: getattr(robot.can, side).model_copy(update={"mode": "csv"}) for side in ("left", "right")}
    return robot.model_copy(update={"can": robot.can.model_copy(update={"joints": joints, **wheels})})


def turn(backend: Any, periods: int) -> None:
    arm = backend.get(Arm)
    for _ in range(periods):
        arm.move(arm.command() + TURN)
        backend.step()


def test_a_set_point_is_reached_one_period_after_its_sync(make: Make, robot: RobotFile) -> None:
    backend = make(robot=robot, room=False)
    arm, seen = backend.get(Arm), []
    for _ in range(4):
        arm.move(arm.command() + TURN)
        backend.step()
        seen.append(arm.joints()[0])
    assert seen == pytest.approx([0.0, 0.01, 0.02, 0.03], abs=1e-5)
    backend.step()
    assert arm.joints()[0] == pytest.approx(0.04, abs=1e-5)
    assert backend.bench.drives[JOINT_1].velocity == pytest.approx(
        0.2 * backend.axes["joint 1"].units.scale, rel=1e-3
    )
    backend.step()
    assert backend.bench.drives[JOINT_1].velocity == 0.0


def test_the_interpolation_period_is_the_control_period_and_read_back(make: Make, robot: RobotFile) -> None:
    backend = make(robot=robot, room=False)
    sdo = backend.axes["joint 1"].sdo
    assert (sdo[0x60C2][1].raw, sdo[0x60C2][2].raw) == (50, -3)
    assert sdo[0x1006].raw == 50_000
    assert (interpolation_time(0.01), interpolation_time(0.0125), interpolation_time(1.0)) == (
        (10, -3),
        (125, -4),
        (100, -2),
    )
    with pytest.raises(ValueError, match="60C2h"):
        interpolation_time(0.0501234)


def test_another_interpolation_period_is_refused(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    from handcart.backends.can.bench.bench import Bench

    plain = Bench.open

    def opened(self: Bench) -> BenchBus:
        self.drives[JOINT_1].wrong.keeps = {(0x60C2, 1): 10}
        return plain(self)

    monkeypatch.setattr(Bench, "open", opened)
    with pytest.raises(ReadBackDiffers, match=r"interpolation time period 1 \(60C2h:1\) is 10; wanted: 50"):
        make(robot=robot, room=False)


def test_drive_missing_a_set_point_reaches_the_last_and_holds(make: Make, robot: RobotFile) -> None:
    backend = make(robot=robot, room=False)
    turn(backend, 5)
    drive, send = backend.bench.drives[JOINT_1], backend.bench.master.send
    lost: list[can.Message] = []

    def loses(frame: can.Message, timeout: float | None = None) -> None:
        if frame.arbitration_id == 0x200 + JOINT_1 and len(lost) < 1:
            lost.append(frame)
        else:
            send(frame, timeout)

    backend.bench.master.send = loses
    turn(backend, 1)
    there = drive.position
    turn(backend, 1)  # nothing new has come with the last SYNC
    scale = backend.axes["joint 1"].units.scale
    assert drive.position == pytest.approx(0.05 * scale, abs=1)
    assert drive.position >= there
    turn(backend, 3)
    backend.step()
    assert drive.position == pytest.approx(0.10 * scale, abs=1)


def test_where_set_points_stay_away_the_drive_stops_by_itself(make: Make, robot: RobotFile) -> None:
    """C5 C7: the time of its RPDO (1400h:5) runs out, and it does as without our heartbeat."""
    backend = make(robot=robot, room=False)
    turn(backend, 5)
    drive, send = backend.bench.drives[JOINT_1], backend.bench.master.send
    backend.bench.master.send = lambda frame, timeout=None: (
        None if frame.arbitration_id == 0x200 + JOINT_1 else send(frame, timeout)
    )
    with pytest.raises(CanFault, match=r"the joint 1 drive \(node 11\)"):
        turn(backend, 10)
    assert drive.life.state == "QUICK STOP ACTIVE"
    assert drive.velocity == 0.0


def test_wheels_run_at_the_speed_of_the_last_sync(make: Make, robot: RobotFile) -> None:
    backend = make(robot=robot, room=False)
    for k in range(12):
        backend.get(Base).drive(0.02 * k, 0.0)
        backend.step()
    # Commands count one period later.
    assert backend.get(Base).wheel_travel().left == pytest.approx(0.05 * 0.02 * sum(range(11)), rel=1e-3)
