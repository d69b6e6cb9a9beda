"""Fingers by CAN: when they count as closed on something, and what a stop leaves them commanded."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.can.can_gripper import CanGripper
from handcart.backends.description.robot_file import RobotFile


@pytest.fixture
def axis() -> Any:
    """Fingers that move at most 0.1 m/s with 400 thousandths of their torque."""
    expected = SimpleNamespace(position=0.02, velocity=0.0)
    limits = SimpleNamespace(torque=400, speed=0.1)
    state = {"position": 0.03, "velocity": 0.0, "torque": 0.0, "tells_torque": True}
    return SimpleNamespace(**state, expected=expected, limits=limits, commands=[])


@pytest.fixture
def gripper(robot: RobotFile, axis: Any) -> CanGripper:
    assert robot.gripper is not None
    axis.command = axis.commands.append
    made = CanGripper(robot.gripper, axis)
    made.begin()
    return made


@pytest.mark.parametrize(
    ("torque", "velocity", "closed"),
    [(-0.2, 0.0, True), (-0.19, 0.0, False), (0.3, 0.0, False), (-0.3, 0.02, True), (-0.3, -0.021, False)],
)
def test_fingers_press_by_half_their_torque_at_rest(
    gripper: CanGripper, axis: Any, torque: float, velocity: float, closed: bool
) -> None:
    axis.torque, axis.velocity = torque, velocity
    assert gripper.closed_on_something() is closed


@pytest.mark.parametrize(
    ("position", "expected_velocity", "closed"),
    [(0.0211, 0.0, True), (0.0209, 0.0, False), (0.0211, -0.01, False), (0.01, 0.0, False)],
)
def test_fingers_without_torque_press_a_millimetre_from_their_target(
    gripper: CanGripper, axis: Any, position: float, expected_velocity: float, closed: bool
) -> None:
    axis.tells_torque, axis.position, axis.expected.velocity = False, position, expected_velocity
    assert gripper.closed_on_something() is closed


def test_a_stop_holds_fingers_where_they_are_and_lets_them_press(gripper: CanGripper, axis: Any) -> None:
    assert gripper.command() == 0.03
    gripper.move(0.01)
    gripper.pass_on()
    axis.torque = -0.3
    gripper.halt()
    assert gripper.command() == 0.01
    axis.torque = 0.0
    gripper.halt()
    assert gripper.command() == 0.03
    axis.position = -0.001
    gripper.halt()
    assert gripper.command() == gripper.width() == 0.0
    axis.position = 1.0
    gripper.begin()
    assert 0.0 < gripper.command() < 0.5
    assert axis.commands == [0.01]
