"""Pose of the base by readings from outside, and by the wheels between them."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.positioning_localizer import PositioningLocalizer

SIGMA = (0.0003, 0.0003)
START = np.diag([0.05, 0.05, 0.03]) ** 2


def noisy(pose: Pose2, rng: np.random.Generator) -> Pose2:
    x, y, turn = (rng.standard_normal(3) * (SIGMA[0], SIGMA[0], SIGMA[1])).tolist()
    return Pose2(pose.x + x, pose.y + y, pose.theta + turn)


def test_at_rest_readings_are_averaged_and_the_covariance_says_so() -> None:
    off = []
    for seed in range(40):
        rng, truth = np.random.default_rng(seed), Pose2(1.03, 1.98, 0.52)
        localizer = PositioningLocalizer(Pose2(1.0, 2.0, 0.5), 0.6, SIGMA, covariance=START)
        for number in range(1, 41):
            localizer.predict(0.0, 0.0)
            localizer.take(number, noisy(truth, rng), 0)
        off.append(localizer.pose.distance(truth))
        sigma = np.sqrt(np.diag(localizer.covariance))
    assert np.sqrt(np.mean(np.square(off)) / 2) == pytest.approx(sigma[0], rel=0.4)
    assert sigma[0] < 0.0001


def test_late_readings_are_carried_on_by_the_wheels() -> None:
    rng, late, step = np.random.default_rng(0), 3, 0.02
    localizer = PositioningLocalizer(Pose2(0.0, 0.0, 0.0), 0.6, SIGMA, covariance=START)
    for number in range(1, 101):
        localizer.predict(step, step)
        if number > late:
            localizer.take(number, noisy(Pose2((number - late) * step + 0.04, 0.01, 0.0), rng), late)
    assert localizer.pose.distance(Pose2(100 * step + 0.04, 0.01, 0.0)) < 0.001


def test_one_broken_reading_is_skipped_and_three_mean_moved() -> None:
    localizer = PositioningLocalizer(Pose2(0.0, 0.0, 0.0), 0.6, SIGMA)
    away = Pose2(0.3, 0.0, 0.1)
    assert not localizer.take(1, away, 0)
    assert not localizer.take(1, away, 0)  # the same one again
    assert localizer.pose == Pose2(0.0, 0.0, 0.0)
    assert not localizer.take(2, away, 0)
    assert localizer.take(3, away, 0)
    assert localizer.pose.distance(away) < 1e-9


def test_outliers_around_a_good_reading_are_not_consecutive() -> None:
    localizer = PositioningLocalizer(Pose2(0.0, 0.0, 0.0), 0.6, SIGMA)
    away, here = Pose2(0.3, 0.0, 0.1), Pose2(0.0, 0.0, 0.0)
    for number, reading in enumerate((away, away, here) * 4, start=1):
        assert not localizer.take(number, reading, 0)
    assert localizer.pose.distance(here) < 1e-6


def test_late_reading_is_compared_with_the_best_past_pose() -> None:
    """The correction of a period is one of that period's pose, too."""
    localizer = PositioningLocalizer(Pose2(0.0, 0.0, 0.0), 0.6, SIGMA, covariance=START)
    truth = Pose2(0.04, 0.01, 0.0)
    localizer.predict(0.0, 0.0)
    localizer.take(1, truth, 0)
    before = localizer.covariance[0, 0]
    localizer.predict(0.0, 0.0)
    localizer.take(2, truth, 1)
    assert localizer.covariance[0, 0] < 0.6 * before
    assert localizer.pose.distance(truth) < 1e-5
