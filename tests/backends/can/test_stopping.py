"""Messages of a stop and their order, so that no later one moves an axis."""

from __future__ import annotations

from typing import Any

import can
import numpy as np
import pytest

from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.errors import CanFault, OffDemand
from handcart.backends.can.simulated.profile_position import ProfilePosition
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_parts import KinematicGripper

from .conftest import LEFT, RIGHT, Make
from .faulty import BEFORE, JOINT_1, fault_of, move


def orders(line: CanLine) -> dict[int, list[int]]:
    """Record the controlwords that are sent from now on, by node."""
    sent: dict[int, list[int]] = {}

    def heard(frame: can.Message, ours: bool) -> None:
        if ours and 0x200 < frame.arbitration_id < 0x280:
            sent.setdefault(frame.arbitration_id - 0x200, []).append(int.from_bytes(frame.data[:2], "little"))

    line.listen(heard)
    return sent


def test_set_points_that_are_not_taken_are_told(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    """C5 B6: the drive goes where it should, but says of three in a row that it didn't take them."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    status: Any = ProfilePosition.status
    plain = status.fget
    monkeypatch.setattr(ProfilePosition, "status", property(lambda self: plain(self) & ~0x1000))
    with pytest.raises(OffDemand, match=r"the joint 1 drive .* 3 set-points in a row were not taken"):
        move(backend, 4)


def test_set_points_that_are_taken_are_forgiven(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two that were lost, one that was taken, and again: no three in a row."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    status: Any = ProfilePosition.status
    plain = status.fget
    before = backend.axes["joint 1"].position
    for number in range(12):
        lost = 0x1000 if number % 3 else 0

        def taken(self: ProfilePosition, bit: int = lost) -> Any:
            return plain(self) & ~bit

        monkeypatch.setattr(ProfilePosition, "status", property(taken))
        move(backend, 1)
    assert backend.axes["joint 1"].position > before + 0.005


def test_a_quick_stop_ends_the_handshake(make: Make, robot: RobotFile) -> None:
    """C12 C22: a requested set-point is not taken when the drive is enabled again."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    joint = backend.axes["joint 1"]
    joint.command(joint.position + 0.01)
    joint.send()
    sent = orders(backend._line)
    joint.quick_stop()
    backend.axes.sync()
    joint.end_handshake()
    backend.bench.serve()
    assert sent[JOINT_1] == [0x02]
    assert backend.bench.drives[JOINT_1].life.state == "QUICK STOP ACTIVE"


def test_of_two_set_points_between_two_answers_the_second_counts(make: Make, robot: RobotFile) -> None:
    """B6: as sent by a stop in the middle of a period; bit 4 has to rise again for it."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    joint, there = backend.axes["joint 1"], backend.axes["joint 1"].position
    sent = orders(backend._line)
    for target in (there + 0.01, there - 0.005):
        joint.command(target)
        joint.send()
    assert sent[JOINT_1] == [0x3F, 0x0F, 0x3F]
    for _ in range(5):
        backend.axes.sync()
        backend.bench.serve()
        backend.bench.tick(backend.period)
    drive = backend.bench.drives[JOINT_1]
    assert drive.demand.position == pytest.approx(joint.units.counts(there - 0.005), abs=1)


def test_after_a_fault_the_drives_take_no_commands(make: Make, robot: RobotFile) -> None:
    """C6 C12: a late command, in the last of all queues, is not executed."""
    backend = make(robot=robot, room=False)
    fault_of(backend, "emergency")
    drives = backend.bench.drives
    assert {drive.nmt.state for drive in drives.values()} == {"PRE-OPERATIONAL"}
    for node in (LEFT, RIGHT, JOINT_1):  # 0Fh: from QUICK STOP ACTIVE back to OPERATION ENABLED
        backend.bench.line.send_message(0x200 + node, b"\x0f\x00\xff\xff\x00\x00")
        drives[node]._on_pdo(drives[node].rpdo[1])
    backend.bench.tick(0.05)
    assert "OPERATION ENABLED" not in {drive.life.state for drive in drives.values()}


def test_wheels_lose_torque_at_the_end_despite_quick_stop_hold(make: Make, robot: RobotFile) -> None:
    """C12: they are commanded so, whatever state their own quick stop ends in."""
    for ends in ("close", "fault"):
        backend = make(robot=robot, room=False)
        move(backend, BEFORE)
        wheels = [backend.bench.drives[node] for node in (LEFT, RIGHT)]
        for wheel in wheels:
            wheel.life.quick_stop_option = 6
        if ends == "close":
            backend.close()
        else:
            fault_of(backend, "emergency", JOINT_1)
        assert [wheel.life.state for wheel in wheels] == ["SWITCH ON DISABLED"] * 2
        assert [wheel.velocity for wheel in wheels] == [0.0, 0.0]
        assert backend.bench.drives[JOINT_1].life.state == "QUICK STOP ACTIVE"  # it would fall


def test_the_torque_goes_when_the_wheels_stand_not_before(make: Make) -> None:
    """C12: without torque they would roll on."""
    backend = make(room=False)
    for _ in range(20):
        backend.get(Base).drive(0.6, 0.0)
        backend.step()
    sent = orders(backend._line)
    drive, speeds = backend.bench.drives[LEFT], []
    plain = drive.life.control

    def control(word: int) -> None:
        speeds.append((word, drive.velocity))
        plain(word)

    drive.life.control = control
    backend.close()
    assert set(sent[LEFT][:-1]) == {0x02}
    assert sent[LEFT][-1] == 0x00
    (quick, moving), *_, (disable, standing) = speeds
    assert (quick, disable) == (0x02, 0x00)
    assert abs(moving) > 1000.0
    assert standing == 0.0


def turned(robot: RobotFile, **drives: Any) -> RobotFile:
    """The robot with some drives' sign turned."""
    spec = robot.can
    assert spec is not None and spec.gripper is not None
    joints = tuple(
        joint.model_copy(update={"sign": -joint.sign}) if number in drives.get("joints", ()) else joint
        for number, joint in enumerate(spec.joints)
    )
    gripper = spec.gripper.model_copy(update={"sign": -spec.gripper.sign if "gripper" in drives else 1})
    return robot.model_copy(update={"can": spec.model_copy(update={"joints": joints, "gripper": gripper})})


def test_torques_have_the_sign_of_the_file(make: Make, robot: RobotFile) -> None:
    """A joint that counts down where the file counts up feels the same force."""
    robot = turned(robot.without_errors(), joints=(1, 2, 4))
    backend = make(robot=robot)
    arm, inner = backend.get(Arm), backend.bench.inner
    backend.step()
    for force in ([0.0, 0.0, 0.0], [-20.0, 3.0, 8.0]):
        for _ in range(2):
            backend.inner.scene.hand_force = np.array(force)
            inner._arm._settled = True  # a gripper in contact does not move
            backend.step()
        backend.inner.scene.hand_force = np.array(force)
        assert arm.hand_force() == pytest.approx(force, abs=0.5)


@pytest.mark.parametrize("sign", ["as it is", "turned"])
def test_fingers_that_press_are_felt_whatever_their_sign(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch, sign: str
) -> None:
    robot = robot if sign == "as it is" else turned(robot, gripper=True)
    backend = make(robot=robot)
    gripper = backend.get(Gripper)
    gripper.move(0.02)
    for _ in range(30):
        backend.step()
    assert not gripper.closed_on_something()
    monkeypatch.setattr(KinematicGripper, "closed_on_something", lambda self: True)
    backend.step()
    backend.step()
    assert gripper.closed_on_something()


def test_a_fault_in_stopping_is_still_the_first_fault(make: Make) -> None:
    backend = make(room=False)
    fault = fault_of(backend, "bus-off")
    with pytest.raises(CanFault) as again:
        backend.stop()
        backend.step()
    assert again.value is fault
