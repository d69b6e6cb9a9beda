from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2


def test_ranges_by_hand() -> None:
    boxes = [(2.0, 0.0, 0.0, 1.0, 1.0), (5.0, 0.0, 0.0, 1.0, 9.0), (0.0, 3.0, math.pi / 4, 2.0, 2.0)]
    seen = box_ranges(boxes, Pose2(0, 0, 0), np.radians([0.0, 90.0, 180.0, -30.0]))
    assert seen == pytest.approx([1.5, 3.0 - math.sqrt(2.0), np.inf, 4.5 / math.cos(math.radians(30.0))])


@given(st.floats(-math.pi, math.pi), st.floats(-5, 5), st.floats(-5, 5))
def test_moving_all_together_changes_nothing(theta: float, x: float, y: float) -> None:
    boxes, sensor, angles = [(2.0, 0.3, 0.4, 1.0, 0.6)], Pose2(0.1, 0.2, 0.05), np.radians([-5.0, 3.0, 9.0])
    move = Pose2(x, y, theta)
    moved = [(*move.compose(Pose2(*box[:3])), *box[3:]) for box in boxes]
    assert np.allclose(box_ranges(moved, move.compose(sensor), angles), box_ranges(boxes, sensor, angles))
