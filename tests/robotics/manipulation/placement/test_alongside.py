"""Straight ways of a base beside a path."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.seam.seam_placer import placer_of
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.alongside import level_with, place_alongside, seen_from
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from ..seams import arched_poses


@pytest.fixture(scope="module")
def placer() -> Placer:
    return placer_of(load_robot("atrv"))


def seam(span: float = 4.6) -> ToolPath:
    return tool_path(arched_poses(300, span=span, low=0.7, rise=0.3), longest_step=0.2)


def nowhere(bases: FloatArray) -> BoolArray:
    """Report that nothing is anywhere."""
    return np.zeros(len(bases), dtype=bool)


@pytest.mark.slow
@given(st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-3.1, 3.1))
def test_a_base_is_level_with_the_tool_and_sees_it_where_it_is(x: float, y: float, heading: float) -> None:
    path, start = seam(), Pose2(x, y, heading)
    bases = level_with(start, path.points)
    seen = seen_from(bases, path)
    assert bases[0].tolist() == pytest.approx([x, y, heading])
    assert seen.points[:, 0] == pytest.approx(np.full(len(bases), seen.points[0, 0]), abs=1e-9)
    for index in (0, 100, 299):
        lifted = Pose2(*bases[index].tolist()).lift()
        assert lifted @ seen.poses[index] == pytest.approx(path.poses[index], abs=1e-9)
        assert lifted[:3, :3] @ seen.tangents[index] == pytest.approx(path.tangents[index], abs=1e-9)


def test_the_arm_follows_all_of_a_seam_from_one_straight_way(placer: Placer) -> None:
    path = seam()
    found = place_alongside(placer, path, nowhere, 4)
    assert len(found.segments) == 1
    assert 0.3 < found.score / path.length <= 1.0
    start = Pose2(*found.bases[0].tolist())
    assert math.sin(start.theta) == pytest.approx(0.0, abs=1e-6)  # along the seam
    angles = placer.joints(np.zeros(3), seen_from(level_with(start, path.points), path))
    bases = level_with(start, path.points)
    for base, q, point in zip(bases[::50], angles[::50], path.points[::50], strict=True):
        tip = (Pose2(*base.tolist()).lift() @ placer.arm.forward(q))[:3, 3]
        assert tip == pytest.approx(point, abs=1e-5)


def test_a_way_keeps_off_what_stands_beside_it(placer: Placer) -> None:
    """An obstacle is on the best route."""
    best = place_alongside(placer, seam(), nowhere, 1).bases[0]
    row = level_with(Pose2(*best.tolist()), seam().points)

    def blocked(bases: FloatArray) -> BoolArray:
        near = np.linalg.norm(bases[:, None, :2] - row[None, 100:200, :2], axis=2).min(axis=1)
        return np.asarray(near < 0.15)

    found = place_alongside(placer, seam(), blocked, 1).bases[0]
    assert abs(found[1] - best[1]) > 0.09


def test_where_no_way_leads_it_says_so(placer: Placer) -> None:
    with pytest.raises(Untrackable, match="drives straight beside the seam"):
        place_alongside(placer, seam(), lambda bases: np.ones(len(bases), dtype=bool), 3)


def test_a_seam_round_a_corner_takes_two_ways(placer: Placer) -> None:
    """Each level with its own part of it."""
    leg = np.tile(np.eye(4), (100, 1, 1))
    leg[:, :3, :3] = arched_poses(2)[0, :3, :3]
    leg[:, 0, 3], leg[:, 2, 3] = np.linspace(0.0, 2.5, 100), 0.9
    turn = Pose2(2.52, -0.02, -0.5 * math.pi).lift()
    path = tool_path(np.vstack((leg, turn @ leg)), longest_step=0.2, longest_turn=2.0)
    found = place_alongside(placer, path, nowhere, 3)
    assert len(found.segments) == 2
    headings = [Pose2(*base.tolist()).theta for base in found.bases]
    assert abs(math.cos(headings[0] - headings[1])) < 0.1
