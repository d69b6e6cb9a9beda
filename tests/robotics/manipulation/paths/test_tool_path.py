"""Paths of tool poses, and those that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.manipulation.paths.tool_path import tool_path
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from tests.robotics.manipulation.seams import arched, arched_poses, straight


def test_tangents_and_lengths_of_a_circle() -> None:
    angle = np.cumsum(np.random.default_rng(0).uniform(0.005, 0.015, 300))
    poses = np.tile(np.eye(4), (300, 1, 1))
    poses[:, 0, 3], poses[:, 1, 3] = np.cos(angle), np.sin(angle)
    poses[:, 0, 0], poses[:, 0, 1] = np.cos(angle), -np.sin(angle)
    poses[:, 1, 0], poses[:, 1, 1] = np.sin(angle), np.cos(angle)
    path = tool_path(poses)
    np.testing.assert_allclose(path.tangents[:, 0], -np.sin(angle), atol=1e-4)
    np.testing.assert_allclose(path.tangents[:, 1], np.cos(angle), atol=1e-4)
    np.testing.assert_allclose(path.turns, np.tile([0.0, 0.0, 1.0], (300, 1)), atol=1e-4)
    assert path.length == pytest.approx(angle[-1] - angle[0], abs=1e-4)
    np.testing.assert_array_equal(path.poses, poses)


def test_a_seam_without_turns_has_no_turn_to_divide_by() -> None:
    path = straight()
    assert not path.turns.any()
    np.testing.assert_allclose(path.twists, np.tile([1.0, 0, 0, 0, 0, 0], (201, 1)), atol=1e-12)


def test_a_part_begins_at_zero() -> None:
    path = arched()
    part = path.part(50, 80)
    assert len(part.points) == 31
    assert part.lengths[0] == 0.0
    assert part.length == pytest.approx(path.lengths[80] - path.lengths[50])


def _broken(row: int, column: int, value: float) -> np.ndarray:
    poses = arched_poses()
    poses[row, column // 4, column % 4] = value
    return poses


@pytest.mark.parametrize(
    ("poses", "index", "why"),
    [
        (_broken(7, 3, np.nan), 7, "isn't finite"),
        (_broken(9, 7, np.inf), 9, "isn't finite"),
        (_broken(11, 3, 1.5), 11, "jumps by"),
        (_broken(5, 0, 2.0), 5, "rotation that is none"),
    ],
)
def test_the_first_bad_point_is_named(poses: np.ndarray, index: int, why: str) -> None:
    poses[150] = np.nan
    with pytest.raises(Untrackable, match=why) as caught:
        tool_path(poses)
    assert caught.value.index == index


def test_a_repeated_point_and_a_sudden_turn_are_refused() -> None:
    poses = arched_poses()
    poses[4] = poses[3]
    with pytest.raises(Untrackable, match="point 4 of the path repeats"):
        tool_path(poses)
    poses = arched_poses()
    poses[30:, :3, :3] = np.eye(3)
    with pytest.raises(Untrackable, match="point 30 of the path turns the tool"):
        tool_path(poses)


def test_one_pose_is_no_path() -> None:
    with pytest.raises(ValueError, match="two poses"):
        tool_path(np.eye(4)[None])
