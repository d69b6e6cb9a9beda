"""The ground truth of a backend, and what moved by it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.ground_truth import GroundTruth
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.judging.true_changes import moved, not_restored
from handcart.evaluation.trials.rig import build_rig
from handcart.robotics.geometry.pose2 import Pose2


def test_it_is_the_same_through_all_that_is_put_around_a_backend() -> None:
    with build_rig() as rig:
        inner: Any = rig.backend
        layered = FaultyBackend(FaultyBackend(inner))
        one, other = inner.ground_truth(), layered.ground_truth()
        assert other is not None
        assert moved(one, other) == dict.fromkeys(moved(one, one), 0.0)
        assert simulated_world(layered) is inner.scene
        assert inner.scene is not None
        inner.scene.base = one.base.compose(Pose2(0.1, 0.0, 0.0))
        now = layered.ground_truth()
        assert now is not None
        assert moved(one, now)["base_mm"] == pytest.approx(100.0)  # and `one` is as it was


@pytest.mark.parametrize(
    ("name", "sigma_mm", "off_mm", "right"),
    [
        ("librarian", 4.0, 44.0, True),
        ("librarian", 4.0, 46.0, False),
        ("librarian", 16.0, 49.0, True),
        ("librarian", 16.0, 51.0, False),
        ("librarian", 736.0, 51.0, False),
        ("el_verde", 100.0, 1049.0, True),
        ("el_verde", 100.0, 1051.0, False),
        ("el_verde", 3000.0, 1101.0, False),
        ("el_verde", float("nan"), 0.0, False),
    ],
)
def test_a_restored_base_is_within_both_limits(
    name: str, sigma_mm: float, off_mm: float, right: bool
) -> None:
    """The limits are that of the claimed sigma, and twice the tolerance of the robot's file whatever the
    sigma.
    """

    def standing(x: float) -> GroundTruth:
        return GroundTruth(Pose2(x, 0.0, 0.0), np.zeros(2), np.zeros(2, dtype=np.bool_), 0.0, {}, 0)

    wrong = not_restored(standing(0.0), standing(off_mm / 1e3), load_robot(name), (sigma_mm, 0.09))
    assert (wrong == []) is right
