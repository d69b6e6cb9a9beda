"""State of a robot on simulated drives: a restored backend continues with the same commands and travel."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.saved_state import NotAState

from ..conftest import Make
from ..faulty import move


@pytest.mark.slow
def test_state_brings_travel_commands_and_time_back(make: Make, robot: RobotFile) -> None:
    left = make(robot=robot)
    for number in range(12):
        left.get(Gripper).move(0.02 + 0.001 * number)
        move(left, 1)
    kept = left.state()
    other = make(robot=robot)
    other.set_state(kept)
    assert other.bench.time == left.bench.time > 0.0
    assert other.get(Base).wheel_travel() == left.get(Base).wheel_travel()
    assert other.get(Base).wheel_travel().left > 0.1
    np.testing.assert_array_equal(other.get(Arm).command(), left.get(Arm).command())
    assert other.get(Gripper).command() == left.get(Gripper).command()
    for wrong in ({}, {"inner": None, "time": 1.0}, "state"):
        with pytest.raises(NotAState, match="needed: inner, time, parts"):
            other.set_state(wrong)
