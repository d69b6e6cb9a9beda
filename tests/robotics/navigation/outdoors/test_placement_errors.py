import math

import numpy as np
import pytest

from benchmarks.field.placement_radius import share_radius, tip_covariance, tip_place
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.placement_errors import aligned_spread, nees


def test_the_tip_is_on_the_right() -> None:
    assert tip_place(Pose2(1.0, 2.0, math.pi / 2)) == pytest.approx([1.75, 2.0])


def test_the_tips_covariance_is_that_of_samples() -> None:
    rng = np.random.default_rng(0)
    covariance = np.diag([0.01, 0.02, 0.005]) + 0.003
    poses = rng.multivariate_normal([1.0, 2.0, 0.7], covariance, 20000)
    tips = np.array([tip_place(Pose2(*pose.tolist())) for pose in poses])
    assert tip_covariance(covariance, 0.7) == pytest.approx(np.cov(tips.T), abs=1e-3)


def test_alignment_takes_out_a_shift_and_a_turn() -> None:
    targets = np.column_stack([np.arange(1.0, 8.0), np.zeros(7)])
    turned = Pose2(0.3, -0.2, 0.05).apply(targets)
    assert aligned_spread(turned - targets, targets) == pytest.approx([0.0, 0.0], abs=1e-12)


def test_no_radius_from_too_few_placements() -> None:
    rng = np.random.default_rng(1)
    runs = [rng.normal(0.0, 1.0, (10, 2)) for _ in range(100)]
    assert share_radius(runs[:99], 0.997) is None
    found = share_radius(runs, 0.997)
    assert found is not None
    assert found.low < math.sqrt(-2.0 * math.log(0.003)) < found.high
    assert share_radius(runs[:5], 0.95) is None


def test_nees_of_an_honest_covariance_is_two() -> None:
    rng = np.random.default_rng(2)
    covariance = np.array([[2.0, 0.5], [0.5, 1.0]])
    errors = rng.multivariate_normal([0.0, 0.0], covariance, 4000)
    assert nees(errors, np.tile(covariance, (4000, 1, 1))).mean() == pytest.approx(2.0, rel=0.05)
