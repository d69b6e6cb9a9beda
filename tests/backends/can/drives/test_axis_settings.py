"""Settings of each drive, object by object, and its behaviour with them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from handcart.backends.can.drives.axis_limits import AxisLimits
from handcart.backends.can.drives.axis_settings import mapping, settings
from handcart.backends.can.drives.expected_motion import ExpectedMotion
from handcart.backends.capabilities.arm import Arm
from handcart.backends.description.robot_file import RobotFile

from ..conftest import Make

LIMITS = AxisLimits(2.0, 4.0, 8.0, -1.0, 1.0, 0.1, 1000)
PROFILE_POSITION, PROFILE_VELOCITY, CYCLIC_POSITION, CYCLIC_VELOCITY = 1, 3, 8, 9


def endless_joint_6(text: Callable[[RobotFile], str]) -> Callable[[RobotFile], str]:
    """Reads a URDF whose last joint of the arm turns without end."""

    def read(self: RobotFile) -> str:
        limited = '<joint name="joint_6" type="revolute">'
        assert limited in text(self)
        return text(self).replace(limited, limited.replace("revolute", "continuous"))

    return read


def set_to(backend: Any, name: str, robot: RobotFile, period: float) -> dict[tuple[int, int], int]:
    assert robot.can is not None
    return {
        (setting.index, setting.subindex): setting.value
        for setting in settings(backend.axes[name], robot.can, period)
    }


def test_a_wheel_is_set_to_stop_by_itself_and_to_its_ramps(make: Make, robot: RobotFile) -> None:
    backend, spec = make(robot=robot, room=False), robot.can
    assert spec is not None
    axis = backend.axes["left wheel"]
    found = set_to(backend, "left wheel", robot, 0.05)
    scale = abs(axis.units.scale)
    assert found[0x1006, 0] == 50_000
    assert found[0x1016, 1] == spec.our_node << 16 | spec.heartbeat_timeout_ms
    assert found[0x1017, 0] == spec.heartbeat_ms
    assert found[0x1029, 1] == 0
    assert found[0x1400, 5] == max(150, spec.heartbeat_timeout_ms)
    assert set_to(backend, "left wheel", robot, 0.1)[0x1400, 5] == max(300, spec.heartbeat_timeout_ms)
    assert (found[0x6007, 0], found[0x605E, 0]) == (3, 2)
    assert found[0x605A, 0] == 2
    speed = round(axis.limits.speed * scale)
    assert (found[0x607F, 0], found[0x6060, 0]) == (speed + 1, 3)
    assert found[0x6080, 0] == math.ceil(60 * speed / axis.spec.counts_per_rev)
    assert found[0x6083, 0] == found[0x6084, 0] == round(axis.limits.acceleration * scale)
    assert found[0x6085, 0] == round(axis.limits.braking * scale)
    assert not {(0x607D, 1), (0x6072, 0), (0x6065, 0), (0x60C2, 1)} & found.keys()


def test_a_joint_holds_at_a_stop_and_keeps_its_limits(make: Make, robot: RobotFile) -> None:
    backend = make(robot=robot, room=False)
    axis = backend.axes["joint 1"]
    found = set_to(backend, "joint 1", robot, 0.05)
    assert found[0x605A, 0] == (6 if axis.spec.stop == "hold" else 2)
    ends = sorted(axis.units.counts(item) for item in (axis.limits.lower, axis.limits.upper))
    assert [found[0x607D, 1], found[0x607D, 2]] == ends
    assert found[0x6072, 0] == axis.limits.torque == 1000
    assert found[0x6065, 0] == axis.units.size(axis.limits.window)
    assert found[0x6066, 0] == axis.spec.following_ms
    fingers = set_to(backend, "gripper", robot, 0.05)
    assert fingers[0x6065, 0] == 0xFFFFFFFF  # they may be blocked
    assert fingers[0x6072, 0] == backend.axes["gripper"].limits.torque


def test_mapped_objects_are_read_back_with_their_bits(make: Make, robot: RobotFile) -> None:
    axis = make(robot=robot, room=False).axes["left wheel"]
    found = {(value.index, value.subindex): value.value for value in mapping(axis)}
    assert found == {
        (0x1400, 2): 255,
        (0x1600, 0): 2,
        (0x1600, 1): 0x60400010,
        (0x1600, 2): 0x60FF0020,
        (0x1800, 2): 1,
        (0x1A00, 0): 3,
        (0x1A00, 1): 0x60410010,
        (0x1A00, 2): 0x60640020,
        (0x1A00, 3): 0x60610008,
        (0x1801, 2): 1,
        (0x1A01, 0): 3,
        (0x1A01, 1): 0x606C0020,
        (0x1A01, 2): 0x60770010,
        (0x1A01, 3): 0x603F0010,
    }


def test_expected_speed_ramps_to_what_is_commanded() -> None:
    motion = ExpectedMotion(PROFILE_VELOCITY, LIMITS)
    ways = []
    for target in (1.0, 1.0, 1.0, -1.0):
        motion.advance(target, 2.0, 0.2)
        ways.append((round(motion.velocity, 9), round(motion.way, 9), round(motion.speed, 9)))
    assert ways[:3] == [(0.8, 0.08, 0.4), (1.0, 0.195, 0.975), (1.0, 0.2, 1.0)]
    assert ways[3][0] == pytest.approx(0.2)


def test_expected_cyclic_targets_count_one_period_later() -> None:
    position = ExpectedMotion(CYCLIC_POSITION, LIMITS)
    position.stand_at(0.5)
    seen = []
    for target in (0.6, 0.8, 0.8):
        position.advance(target, 2.0, 0.1)
        seen.append((position.position, round(position.velocity, 9), round(position.way, 9)))
    assert seen == [(0.5, 0.0, 0.0), (0.6, 1.0, 0.1), (0.8, 2.0, 0.2)]
    speed = ExpectedMotion(CYCLIC_VELOCITY, LIMITS)
    speed.stand_at(0.5)
    ways = []
    for target in (1.0, 2.0, 2.0):
        speed.advance(target, 2.0, 0.1)
        ways.append(round(speed.way, 9))
    assert ways == [0.0, 0.1, 0.2]
    assert speed.position == pytest.approx(0.8)


def test_an_expected_position_is_reached_and_held() -> None:
    motion = ExpectedMotion(PROFILE_POSITION, LIMITS)
    motion.stand_at(-0.2)
    assert (motion.position, motion.velocity) == (-0.2, 0.0)
    for _ in range(40):
        motion.advance(0.3, 1.0, 0.05)
        assert abs(motion.velocity) <= 1.0
    assert motion.position == pytest.approx(0.3)
    assert motion.velocity == 0.0


def test_a_joint_without_end_is_driven_over_a_turn(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(RobotFile, "urdf_text", endless_joint_6(RobotFile.urdf_text))
    backend = make(robot=robot, room=True)
    found = set_to(backend, "joint 6", robot, 0.05)
    assert (found[0x607D, 1], found[0x607D, 2]) == (-(2**31), 2**31 - 1)
    arm = backend.get(Arm)
    wanted = arm.command().copy()
    for _ in range(60):
        wanted[5] += 0.06
        arm.move(wanted)
        backend.step()
    backend.step()
    assert wanted[5] > math.pi
    assert arm.joints()[5] == pytest.approx(wanted[5], abs=0.07)
