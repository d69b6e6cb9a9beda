"""Averaged ranges of a base that hardly moves."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.averaged_scan import AveragedScan
from handcart.robotics.geometry.pose2 import Pose2

ANGLES = np.linspace(-np.pi, np.pi, 90, endpoint=False)


class Standing:
    """A base with noisy scans of a wall at 1 m, and its pose."""

    def __init__(self) -> None:
        self.pose, self.rng = Pose2(0.0, 0.0, 0.0), np.random.default_rng(1)
        self.averaged = AveragedScan(lambda: self.pose)

    def look(self, distance: float = 1.0) -> np.ndarray:
        ranges = distance + 0.01 * self.rng.standard_normal(len(ANGLES))
        ranges[:5] = np.inf
        return self.averaged.take(Scan(ANGLES, ranges, Pose2(0.0, 0.0, 0.0))).ranges


@pytest.fixture
def standing() -> Standing:
    return Standing()


def test_noise_shrinks_while_the_base_stands(standing: Standing) -> None:
    first = standing.look()
    for _ in range(19):
        last = standing.look()
    assert np.std(last[5:]) < 0.4 * np.std(first[5:])
    assert np.isinf(last[:5]).all()


def test_what_comes_near_counts_at_once(standing: Standing) -> None:
    for _ in range(20):
        standing.look()
    assert np.all(np.abs(standing.look(0.5)[5:] - 0.5) < 0.05)


def test_a_moved_base_begins_anew(standing: Standing) -> None:
    for _ in range(20):
        standing.look()
    standing.pose = Pose2(0.01, 0.0, 0.0)
    assert np.std(standing.look()[5:]) > 0.006
