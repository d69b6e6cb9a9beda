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


FINE_ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)


def ranges_in_room(pose: Pose2) -> np.ndarray:
    """Return the true ranges of a room with walls at 0.4 and -0.7 m in x, and at 0.5 and -0.5 m in y."""
    rays = np.column_stack([np.cos(FINE_ANGLES + pose.theta), np.sin(FINE_ANGLES + pose.theta)])
    walls = np.where(rays > 0.0, [0.4 - pose.x, 0.5 - pose.y], [-0.7 - pose.x, -0.5 - pose.y])
    return np.asarray((walls / np.where(np.abs(rays) < 1e-9, 1e-9, rays)).min(axis=1))


def test_noise_shrinks_while_the_base_turns_to_and_fro(standing: Standing) -> None:
    """Also beside the middle: the lidar moves on a circle."""
    mount, errors = Pose2(0.1, 0.0, 0.3), []
    for i in range(60):
        standing.pose = Pose2(0.0, 0.0, 0.3 * np.sin(0.25 * i))
        true = ranges_in_room(standing.pose.compose(mount))
        noisy = true + 0.01 * standing.rng.standard_normal(len(true))
        errors.append(standing.averaged.take(Scan(FINE_ANGLES, noisy, mount)).ranges - true)
    assert np.std(errors[0]) > 0.008
    assert max(np.std(error) for error in errors[20:]) < 0.006
    assert max(np.abs(error).max() for error in errors) < 0.04


def test_turned_average_leaves_out_what_no_beam_saw(standing: Standing) -> None:
    """A scan of half a turn has nothing to say about the beams that come into view."""
    angles, sensor = ANGLES[:45], Pose2(0.0, 0.0, 0.0)
    standing.averaged.take(Scan(angles, np.full(45, 1.0), sensor))
    standing.pose = Pose2(0.0, 0.0, 0.5)
    taken = standing.averaged.take(Scan(angles, np.full(45, 1.02), sensor)).ranges
    assert np.allclose(taken[-6:], 1.02)
    assert np.allclose(taken[:30], 1.01)
