"""The recorded track of a run: on the map, also where the robot did not know yet where it was."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.networks.run_files.telemetry import on_the_map
from handcart.robotics.geometry.pose2 import Pose2


def test_poses_before_the_robot_is_located_are_moved_onto_the_map() -> None:
    map_T_local = Pose2(5.0, 4.0, 2.0)
    local = [Pose2(0.2 * number, 0.1, 0.05 * number) for number in range(5)]
    true = [map_T_local.compose(pose) for pose in local]
    rows = np.array([*local[:4], true[3], true[4]])
    found = on_the_map(rows, np.array([False] * 4 + [True] * 2))
    assert found == pytest.approx(np.array([*true[:4], true[3], true[4]]))


def test_poses_of_a_robot_that_never_knew_are_unknown() -> None:
    rows = np.arange(12.0).reshape(4, 3)
    found = on_the_map(rows, np.array([True, False, False, False]))
    assert found[0] == pytest.approx(rows[0])
    assert np.isnan(found[1:]).all()
    assert on_the_map(np.empty((0, 3)), np.empty(0, dtype=np.bool_)).shape == (0, 3)
