"""Errors of a simulated arm."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.body.simulated_parts import ArmError


@pytest.mark.parametrize("name", ["toyama", "librarian", "atrv"])
def test_the_hand_errs_as_drawn_but_where_joints_would_have_to_leap(name: str) -> None:
    """Near a singular posture 0.3 mm at the hand were 0.7 rad in a joint."""
    spec = load_robot(name)
    arm, rng = spec.arm_model(), np.random.default_rng(0)
    errors = spec.errors.model_copy(update={"joint_repeatability_mrad": 0.0, "hand_repeat_mm": 0.3})
    error = ArmError(errors, arm, 0)
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    given, shown = [], []
    for joints in rng.uniform(low, high, (400, len(low))):
        offset = error.offset(joints, 1)
        given.append(float(np.linalg.norm(offset)))
        shown.append(float(np.linalg.norm((arm.forward(joints + offset) - arm.forward(joints))[:3, 3])))
    assert max(given) < 5.001e-3
    assert 2e-4 < np.median(shown) < 1.5e-3
