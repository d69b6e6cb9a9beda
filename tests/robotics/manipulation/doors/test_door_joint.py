"""Joints of doors and drawers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.transform import transform
from handcart.robotics.manipulation.doors.door_joint import DoorJoint

CLOSED = transform((3.0, 1.0, 0.9), (0.0, 0.0, math.pi))
HINGED = DoorJoint(CLOSED, (-0.05, -0.8), -1.0)
SLIDING = DoorJoint(CLOSED, None, 1.0)


@pytest.mark.parametrize("joint", [HINGED, SLIDING])
def test_opening_of_a_handle_is_that_of_its_place(joint: DoorJoint) -> None:
    handle = joint.handle_at(0.3)
    assert joint.opening_at(handle[:3, 3]) == pytest.approx(0.3)
    assert joint.opening_of(handle) == pytest.approx(0.3)
    np.testing.assert_allclose(joint.with_handle(handle, 0.3).closed, CLOSED, atol=1e-9)


def test_handle_of_a_door_stays_at_its_radius() -> None:
    hinge = (CLOSED @ (-0.05, -0.8, 0.0, 1.0))[:2]
    away = [np.linalg.norm(HINGED.handle_at(opening)[:2, 3] - hinge) for opening in (0.0, 0.4, 1.2)]
    np.testing.assert_allclose(away, HINGED.radius)
    assert HINGED.handle_at(0.4)[0, 3] < 3.0  # towards a person in front of it


def test_heading_of_a_drawer_is_out_of_its_front() -> None:
    assert abs(math.remainder(SLIDING.heading(0.0) - math.pi, 2 * math.pi)) < 1e-6
    assert (SLIDING.curvature(), SLIDING.travel(0.2)) == (0.0, 0.2)
