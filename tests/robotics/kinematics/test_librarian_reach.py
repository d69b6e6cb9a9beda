"""The librarian's arm reaches what its work asks, away from singularities and from itself."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from tests.robotics.kinematics.singular import smallest_gain

READY = np.array([-0.941, -0.9967, 2.3301, -0.9545, -1.4318, 0.1931])
SPINES = 0.47  # base x of the spines' plane where the robot works at a shelf
WORK: dict[str, list[tuple[float, float, float]]] = {
    "look at the tag of a tall book": [(0.07 - d, -0.08, 0.84) for d in (0.18, 0.21, 0.25)],
    "look at the tag of a short book": [(0.07 - d, -0.08, 0.78) for d in (0.18, 0.21, 0.25)],
    "grip and lift": [(-0.07, 0, 0.74), (-0.02, 0, 0.71), (-0.02, 0, 0.74), (-0.02, 0, 0.86)],
    "search": [(SPINES - 0.33, y - 0.08, z) for z in (0.76, 0.82) for y in np.linspace(-0.5, 0.5, 9)],
    "insert": [
        (SPINES - 0.12 - back, y, z)
        for y in np.linspace(-0.45, 0.45, 7)
        for z in (0.79, 0.82)
        for back in (0.2, 0)
    ],
}


@pytest.mark.parametrize("work", WORK)
def test_reach(arm: ArmModel, work: str) -> None:
    for position in WORK[work]:
        q = arm.inverse(transform(position), near=READY)
        assert q is not None, position
        assert smallest_gain(arm, q) > 0.14, position
        assert min(np.min(q - arm.lower), np.min(arm.upper - q)) > 0.25, position
