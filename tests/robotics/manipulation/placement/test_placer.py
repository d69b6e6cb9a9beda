"""Dividing a path among places for a whole robot arm, and why one can't be."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.placement_division import TooFewPlacements
from handcart.robotics.manipulation.placement.placements import Placements, Work
from handcart.robotics.manipulation.placement.placer import Placer

from ..seams import arched, five_joint_urdf
from ..tool_errors import tool_errors

WORK = Work(speed=0.2, force=40.0, free=FreeTurn.VERTICAL, azimuth_tolerance=np.radians(60.0))


def nothing_blocked(bases: np.ndarray) -> np.ndarray:
    return np.zeros(len(bases), dtype=bool)


def below(bases: np.ndarray) -> np.ndarray:
    """A work piece that no base may be under, or behind."""
    return np.asarray(bases[:, 1] > -0.3)


@pytest.fixture(scope="module")
def placer() -> Placer:
    return Placer(ArmModel(five_joint_urdf(), [f"j{number}" for number in range(1, 6)]), WORK)


@pytest.fixture(scope="module")
def path() -> ToolPath:
    return arched(100)


@pytest.fixture(scope="module")
def placed(placer: Placer, path: ToolPath) -> Placements:
    return placer.place(path, below)


def test_parts_follow_each_other_and_the_arm_follows_each(
    placer: Placer, path: ToolPath, placed: Placements
) -> None:
    segments = placed.segments
    assert segments[0].first == 0
    assert segments[-1].last == len(path.points) - 1
    assert [path_segment.first for path_segment in segments[1:]] == [
        path_segment.last for path_segment in segments[:-1]
    ]
    assert 0.0 < placed.score < path.length
    assert not below(placed.bases).any()
    for segment in segments:
        base, part = placed.bases[segment.placement], path.part(segment.first, segment.last)
        angles = placer.joints(base, part)
        tips = [placer.arm.forward(q)[:3, 3] for q in angles]
        world_T_base = Pose2(*base.tolist()).lift()
        there = (world_T_base[:3, :3] @ np.array(tips).T).T + world_T_base[:3, 3]
        assert np.abs(there - part.points).max() < 1e-6


def test_the_same_path_has_the_same_places(placer: Placer, path: ToolPath, placed: Placements) -> None:
    again = placer.place(path, below)
    assert np.array_equal(again.bases, placed.bases)
    assert again.segments == placed.segments


def test_a_long_path_leaves_the_grid_of_the_next_one_as_it_was(placer: Placer, path: ToolPath) -> None:
    spacing, bases = placer.spacing, placer.candidates(path)
    stretched = path.points * (30.0, 30.0, 1.0)
    placer.candidates(ToolPath(stretched, path.lengths * 30.0, *path[2:]))
    assert placer.spacing > spacing
    assert np.array_equal(placer.candidates(path), bases)
    assert placer.spacing == spacing


def test_one_more_place_has_to_be_worth_its_cost(placer: Placer, path: ToolPath, placed: Placements) -> None:
    fewest = len(placed.segments)
    free = placer.place(path, below, fewest + 2, cost=1e-6)
    dear = placer.place(path, below, fewest + 2, cost=100.0)
    assert len(dear.segments) == fewest
    assert len(free.segments) > fewest
    assert free.score > placed.score


def test_what_touches_something_is_left_out(placer: Placer, path: ToolPath, placed: Placements) -> None:
    bad = placed.bases[placed.segments[0].placement]
    other = placer.place(path, below, free=lambda base, angles: bool(np.hypot(*(base - bad)[:2]) > 0.04))
    assert np.hypot(*(other.bases - bad)[:, :2].T).min() > 0.04


def test_too_few_places_are_told_with_the_point_that_they_reach(placer: Placer, path: ToolPath) -> None:
    with pytest.raises(TooFewPlacements, match=r"is as far as 1 placements get; needed: [234]") as few:
        placer.place(path, below, 1)
    assert 0 < few.value.index < len(path.points) - 1


@pytest.mark.parametrize(
    ("height", "blocked", "why"),
    [
        (3.0, nothing_blocked, "is out of the arm's reach, wherever the base stands"),
        (
            0.7,
            lambda bases: np.ones(len(bases), dtype=bool),
            "is reached only from where the base can't stand",
        ),
    ],
)
def test_it_is_told_why_a_point_cannot_be_tracked(
    placer: Placer, height: float, blocked: object, why: str
) -> None:
    with pytest.raises(Untrackable, match=why) as caught:
        placer.place(arched(60, low=height), blocked)  # type: ignore[arg-type]
    assert caught.value.index == 0
    if height > 1.0:
        nearest = caught.value.nearest
        assert nearest is not None
        assert nearest[2] < height


def test_an_arm_that_is_too_slow_is_told() -> None:
    arm = ArmModel(five_joint_urdf(), [f"j{number}" for number in range(1, 6)])
    hasty = Placer(arm, WORK._replace(speed=2.4, force=1.0))
    with pytest.raises(Untrackable, match=r"nowhere with 2\.4 m/s and 1 N along the path"):
        hasty.place(arched(60, rise=0.0), below)


@pytest.mark.slow
def test_arm_without_closed_form_works_from_beside_its_place(arm: ArmModel) -> None:
    placer = Placer(arm, Work(0.05, 5.0, FreeTurn.TOOL, 0.0))
    path = arched(30, span=0.4, rise=0.0, low=0.75, pitch_deg=-10.0)
    placed = placer.place(path, below)
    for segment in placed.segments:
        part = path.part(segment.first, segment.last)
        for beside in ((0.025, 0.0, 0.0), (0.0, -0.025, 0.0)):
            base = placed.bases[segment.placement] + np.array(beside)
            angles = placer.joints(base, part)
            errors = tool_errors(placer.follower.arm, part, Pose2(*base.tolist()).lift(), angles)
            assert errors.max() < 1e-6
