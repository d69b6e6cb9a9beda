"""Limits and units of axes, from the robot's file: exact figures."""

from __future__ import annotations

import math

import pytest

from handcart.backends.can.drives.axes import planned_axes
from handcart.backends.can.drives.axis_units import AxisUnits, unwrapped
from handcart.backends.description.robot_file import RobotFile


def test_a_wheel_keeps_up_with_driving_and_turning_at_once(robot: RobotFile) -> None:
    assert robot.can is not None
    drive, half = robot.drive, robot.drive.tread_m / 2
    planned = {name: (units, limits) for name, _, units, limits in planned_axes(robot, robot.can)}
    for name, spec in zip(("left wheel", "right wheel"), robot.can.wheels, strict=True):
        units, limits = planned[name]
        assert limits.speed == pytest.approx(drive.top_speed_m_s + math.radians(drive.top_turn_deg_s) * half)
        rate = drive.acceleration_m_s2 + math.radians(drive.turn_acceleration_deg_s2) * half
        assert limits.acceleration == pytest.approx(rate)
        assert limits.braking == pytest.approx(2.0 * rate)
        assert (limits.lower, limits.upper, limits.torque) == (-math.inf, math.inf, 1000)
        assert limits.window == pytest.approx(spec.following_mm / 1e3)
        assert units == AxisUnits(spec.counts_per_m(drive.wheel_radius_m), 0)


def test_a_joint_and_the_fingers_have_ramps_quicker_than_motions(robot: RobotFile) -> None:
    assert robot.can is not None
    assert robot.gripper is not None
    assert robot.can.gripper is not None
    model = robot.arm_model()
    planned = {name: (units, limits) for name, _, units, limits in planned_axes(robot, robot.can)}
    assert len(planned) == 3 + len(robot.can.joints)
    for place, spec in enumerate(robot.can.joints):
        units, limits = planned[f"joint {place + 1}"]
        rate = robot.joint_accelerations()[place]
        assert limits.speed == min(model.velocity[place], robot.joint_speeds()[place])
        assert limits.acceleration == pytest.approx(10.0 * rate)
        assert limits.braking == pytest.approx(2.0 * rate)
        assert (limits.lower, limits.upper) == (model.lower[place], model.upper[place])
        assert (limits.window, limits.torque) == (spec.following, 1000)
        assert units == AxisUnits(spec.counts_per_unit, spec.zero_counts)
    _, limits = planned["gripper"]
    assert limits.speed == pytest.approx(robot.gripper.speed_mm_s / 1e3)
    assert limits.acceleration == limits.braking == pytest.approx(20.0 * limits.speed)
    assert limits.lower == 0.0
    assert limits.upper == pytest.approx(robot.gripper.opening_mm / 1e3)
    assert limits.window == math.inf
    assert limits.torque == round(10.0 * robot.can.gripper.top_torque_percent)


def test_units_convert_counts_with_their_zero_and_sign() -> None:
    units = AxisUnits(-1000.0, 50)
    assert (units.counts(0.25), units.position(-200), units.position(50)) == (-200, 0.25, 0.0)
    assert (units.rate(0.5), units.size(0.5), units.size(-0.5), units.speed(-500)) == (-500, 500, 500, 0.5)


@pytest.mark.parametrize(
    ("counts", "before", "size", "moved"),
    [
        (5, 3, 256, 2),
        (2, 254, 256, 4),
        (254, 2, 256, -4),
        (128, 0, 256, -128),
        (-(2**31), 2**31 - 1, 2**32, 1),
    ],
)
def test_counts_that_start_over_go_on(counts: int, before: int, size: int, moved: int) -> None:
    assert unwrapped(counts, before, size) == moved
