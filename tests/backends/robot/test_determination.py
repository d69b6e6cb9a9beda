"""Decision whether a covariance determines a pose as exactly as needed, by direction."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.robot.localization.determination import (
    PoseNeed,
    Undetermined,
    difference,
    room_left,
    undetermined,
)
from handcart.robotics.geometry.pose2 import Pose2

NEED = PoseNeed(0.04, math.radians(1.0))


def along(angle: float, sigma: float) -> np.ndarray:
    """Covariance of a pose that is uncertain in one direction."""
    ray = np.array([math.cos(angle), math.sin(angle), 0.0])
    return np.diag([1e-6, 1e-6, 1e-6]) + sigma**2 * np.outer(ray, ray)


@pytest.mark.parametrize("angle", [0.0, 0.5, -1.2, 0.5 * math.pi])
def test_one_uncertain_direction_is_named(angle: float) -> None:
    found = undetermined(along(angle, 0.1), NEED)
    assert found is not None
    assert found.direction is not None
    assert math.cos(2.0 * (found.direction - angle)) == pytest.approx(1.0, abs=1e-6)
    assert found.shown == pytest.approx((300.0, 40.0), abs=0.1)
    assert "3 sigma 300 mm, at most 40 mm" in found.words


def test_what_the_pose_is_off_counts_in_its_own_direction_only() -> None:
    spread = along(0.0, 0.012)
    assert undetermined(spread, NEED) is None
    assert undetermined(spread, NEED, (0.0, 0.03, 0.0)) is None
    assert undetermined(spread, NEED, (0.01, 0.0, 0.0)) is not None


def test_a_shift_counts_along_its_own_direction_and_in_the_room() -> None:
    spread, shift = np.diag([4e-3, 4e-3, 1e-3]) ** 2, np.array([0.025, 0.025])
    found = undetermined(spread, NEED, (0.002, 0.002, 0.0), shift)
    assert found is not None
    assert found.direction == pytest.approx(math.radians(45.0))
    assert found.size == pytest.approx(1.594 * 0.004 + 0.027 * math.sqrt(2.0), abs=1e-4)
    assert undetermined(spread, NEED, (0.002, 0.002, 0.0), 0.5 * shift) is None
    assert undetermined(spread, NEED, (0.003, -0.003, 0.0), 0.75 * shift) is None
    assert room_left(spread, NEED, shift)[0] == pytest.approx(
        0.04 - 1.594 * 0.004 - 0.025 * math.sqrt(2.0), abs=2e-4
    )


@pytest.mark.parametrize("sigma", [(0.002, 0.002), (0.004, 0.004), (0.008, 0.003), (0.02, 0.02)])
def test_a_bias_and_noise_are_within_the_claim_in_997_of_1000(sigma: tuple[float, float]) -> None:
    """A wall is anywhere in its cell: the bias is anywhere up to the largest shift, noise on top of it."""
    rng, shift = np.random.default_rng(4), np.array([0.02, 0.008])
    spread = np.diag([*sigma, 1e-4]) ** 2
    found = undetermined(spread, PoseNeed(0.001, 1.0), shift=shift)
    assert found is not None
    angle = found.direction or 0.0
    axis = np.array([math.cos(angle), math.sin(angle)])
    biases = rng.uniform(-1.0, 1.0, (200_000, 1)) * shift
    errors = biases + rng.multivariate_normal(np.zeros(2), spread[:2, :2], len(biases))
    assert np.mean(np.abs(errors @ axis) <= found.size) == pytest.approx(0.9973, abs=0.0006)


@pytest.mark.parametrize("axis", [0.0, 0.7, 0.5 * math.pi, -2.0])
def test_a_need_by_direction_is_held_along_and_across(axis: float) -> None:
    """500 mm along a heading, 40 across: what is uncertain across counts, however the place is turned."""
    need = PoseNeed(0.5, math.radians(1.0), 0.04, axis)
    ahead, aside = along(axis, 0.1), along(axis + 0.5 * math.pi, 0.1)
    assert undetermined(ahead, need) is None
    found = undetermined(aside, need)
    assert found is not None
    assert found.direction is not None
    assert math.cos(2.0 * (found.direction - axis)) == pytest.approx(-1.0, abs=1e-6)
    assert found.shown == pytest.approx((300.0, 40.0), abs=0.1)
    off = 0.45 * math.cos(axis), 0.45 * math.sin(axis), 0.0
    assert undetermined(along(axis, 0.01), need, off) is None
    assert undetermined(along(axis, 0.02), need, off) is not None
    assert room_left(ahead, need)[0] == pytest.approx(0.04 - 3e-3, abs=1e-4)


def test_an_uncertain_heading_is_named() -> None:
    found = undetermined(np.diag([1e-6, 1e-6, math.radians(0.5) ** 2]), NEED)
    assert found is not None
    assert found.direction is None
    assert found.words == "the heading is not determined: 3 sigma 1.50 deg, at most 1.00 deg allowed"


def test_a_small_limit_is_not_shown_as_zero() -> None:
    assert Undetermined(0.0, 0.019, 1e-5).words.endswith("3 sigma 19.0000 mm, at most 0.0100 mm allowed")
    assert Undetermined(0.0, 0.0027, 0.0026).words.endswith("3 sigma 2.70 mm, at most 2.60 mm allowed")


def test_a_pose_that_nothing_tells_is_determined_nowhere() -> None:
    assert undetermined(np.diag([math.inf] * 3), NEED) is not None


def test_a_difference_of_headings_is_the_short_way() -> None:
    off = difference(Pose2(1.0, 2.0, math.pi - 0.1), Pose2(0.5, 2.5, -math.pi + 0.1))
    assert off == pytest.approx((0.5, -0.5, -0.2))
