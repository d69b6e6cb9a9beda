"""Room for a base whose arm follows a path."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.driving.standing_room import COLLISION_CHECK_STRIDE, StandingRoom
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.navigation.maps.grid_map import from_boxes


@pytest.mark.parametrize("count", range(2, 2 * COLLISION_CHECK_STRIDE + 2))
def test_contact_at_the_end_of_a_path_leaves_no_room(count: int) -> None:
    spec = load_robot("xarm_cart")
    arm, home = spec.arm_model(), np.array(spec.posture("home"))
    ahead = transform((0.55, 0.0, 0.8), (0.0, 0.0, 0.0))
    end = arm.inverse(ahead, home)
    assert end is not None
    box = Box(ahead, (0.04, 0.04, 0.04), "work")
    grid = from_boxes([], 0.05, (-2.0, -2.0), (4.0, 4.0))
    room = StandingRoom(spec, arm, grid, np.empty((0, 2)), Pose2(0.0, 0.0, 0.0), (box,))
    path = np.array([home] * (count - 1) + [end])
    assert room.free(np.zeros(3), path[:-1])
    assert not room.free(np.zeros(3), path)
