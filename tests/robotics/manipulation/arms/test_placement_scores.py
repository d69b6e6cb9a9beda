"""Scores of placements: the figures of Shin (2005), closed forms against each other, bounds, refinement."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.seam.directional_manipulability import (
    directional,
    manipulability,
    top_speed,
)
from benchmarks.seam.greedy_division import greedy_division
from benchmarks.seam.performance import sure_performance
from benchmarks.seam.placement_bound import score_bound
from benchmarks.seam.planar_arm import PlanarArm
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.arms.score_rule import Measure, ScoreRule
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn, ScrewArm
from handcart.robotics.manipulation.placement.placement_division import best_division
from handcart.robotics.manipulation.placement.placement_refinement import refine
from tests.robotics.manipulation.seams import arched, five_joint_urdf, stands, straight

pytestmark = pytest.mark.slow

PLANAR = stands((0.0, 4.4, 89), (-1.95, -0.05, 39))


def _rule(measure: Measure) -> ScoreRule:
    return ScoreRule.uniform(measure, 0.5, 1.8, 2)


def test_figure_2_distances_grow_and_first_lengths_shrink() -> None:
    path = straight()
    distances, firsts = [], []
    for measure in (Measure.REACHABILITY, Measure.MANIPULABILITY, Measure.DIRECTIONAL):
        division = greedy_division(PlanarArm().scores(PLANAR, path, _rule(measure)), path.lengths)
        first = division.segments[0]
        distances.append(-PLANAR[first.placement, 1])
        firsts.append(path.lengths[first.last])
    assert distances[0] < distances[1] < distances[2]
    assert firsts[0] > firsts[1] > firsts[2]


def test_with_the_exact_speed_condition_the_halves_are_equal() -> None:
    path = straight()
    division = best_division(PlanarArm().scores(PLANAR, path, _rule(Measure.SURE)), path.lengths, 2)
    first, second = division.segments
    assert path.lengths[first.last] == pytest.approx(0.5 * path.length, rel=0.01)
    assert PLANAR[first.placement, 1] == PLANAR[second.placement, 1]


def test_equation_6_alone_breaks_the_speed_limit() -> None:
    path = straight()
    printed, sure = (
        PlanarArm().scores(PLANAR, path, _rule(measure)) for measure in (Measure.DIRECTIONAL, Measure.SURE)
    )
    assert 0.02 < 1.0 - sure.usable.sum() / printed.usable.sum() < 0.3


def test_the_planar_table_is_made_of_the_general_measures() -> None:
    path, arm, rule = straight(points=111), PlanarArm(0.9, 0.6), _rule(Measure.SURE)
    scores = arm.scores(PLANAR[::7], path, rule)
    spread = arm.scores(PLANAR[::7], path, _rule(Measure.MANIPULABILITY))
    for base, values, wide in zip(PLANAR[::7], scores.values, spread.values, strict=True):
        q = arm.joints(base, path.points)
        known = np.abs(np.sin(q[:, 1])) > 1e-6  # stretched out, the last bit decides
        J, k = arm.jacobian(q[known]), path.tangents[known, :2]
        fastest = top_speed(J, k, 1.0 / rule.low)
        expected = sure_performance(directional(J, k), rule.low, rule.high, fastest, 1.0)
        np.testing.assert_allclose(values[known], expected, atol=1e-6)
        np.testing.assert_allclose(wide[known], manipulability(J), atol=1e-6)
        assert not values[np.isnan(q[:, 0])].any()


@pytest.fixture(scope="module")
def five() -> ArmModel:
    return ArmModel(five_joint_urdf(), [f"j{number}" for number in range(1, 6)])


@pytest.mark.parametrize("measure", list(Measure))
def test_the_closed_form_and_the_urdf_agree(five: ArmModel, measure: Measure) -> None:
    path, bases = arched(60), stands((-1.5, 1.5, 5), (-1.5, -0.5, 5), 4)
    general = ScrewArm(five, FreeTurn.VERTICAL, np.radians(60.0))
    found = general.scores(bases, path, ScoreRule.uniform(measure, 0.2, 1.0, 5))
    closed = PitchArm().scores(bases, path, ScoreRule.uniform(measure, 0.2, 1.0, 4))
    both = found.usable & closed.usable
    assert both.sum() > 0.97 * closed.usable.sum()
    assert (found.usable & ~closed.usable).sum() < 0.01 * both.sum()
    if measure != Measure.MANIPULABILITY:
        np.testing.assert_allclose(found.values[both], closed.values[both], atol=1e-5)


def test_joints_put_the_tool_on_the_path(five: ArmModel) -> None:
    path, base = arched(40, span=1.2), np.array([0.1, -1.2, 1.3])
    q = PitchArm().joints(base, path)
    assert np.isfinite(q).all()
    cos, sin = np.cos(base[2]), np.sin(base[2])
    for angles, point in zip(q, path.points, strict=True):
        tip = five.forward(np.append(angles, 0.0))
        world = base[:2] + np.array([[cos, -sin], [sin, cos]]) @ tip[:2, 3]
        np.testing.assert_allclose((*world, tip[2, 3]), point, atol=1e-9)
        assert np.arcsin(tip[2, 0]) == pytest.approx(np.radians(-35.0))


def test_refined_placements_are_worth_more_and_below_the_bound() -> None:
    path, rule, arm = straight(points=101), _rule(Measure.SURE), PlanarArm()
    division = best_division(arm.scores(PLANAR, path, rule), path.lengths, 2)
    refined = refine(
        lambda bases, part: arm.scores(bases, part, rule), path, PLANAR, division, radius=0.05, turn=0.1
    )
    assert refined.gain > 0.0
    bounds = [
        score_bound(arm, path, rule, np.array([-0.5, -2.0]), np.array([5.4, 2.0]), step, 2)
        for step in (0.1, 0.05, 0.02)
    ]
    assert refined.division.score <= bounds[2] <= bounds[1] <= bounds[0]


@pytest.mark.parametrize("measure", [Measure.DIRECTIONAL, Measure.SURE])
def test_no_placement_beats_the_bound(measure: Measure) -> None:
    rng = np.random.default_rng(4)
    path, arm, rule = arched(50), PitchArm(), ScoreRule.uniform(measure, 0.2, 1.0, 4)
    bound = score_bound(arm, path, rule, np.array([-2.5, -1.6]), np.array([5.0, 1.6]), 0.05, 3)
    shoulders = rng.uniform([-2.5, -1.6, -np.pi], [2.5, 0.0, np.pi], (3000, 3))
    bases = shoulders.copy()
    bases[:, 0] -= arm.ahead * np.cos(bases[:, 2])
    bases[:, 1] -= arm.ahead * np.sin(bases[:, 2])
    assert best_division(arm.scores(bases, path, rule), path.lengths, 3).score <= bound


def test_limits_that_leave_no_room_are_refused() -> None:
    with pytest.raises(ValueError, match="joint 1 has no lever"):
        ScoreRule.of_limits(Measure.SURE, np.array([1.0, 0.1]), np.array([50.0, 5.0]), 0.2, 10.0)
    with pytest.raises(ValueError, match="above zero"):
        ScoreRule.of_limits(Measure.SURE, np.array([1.0]), np.array([50.0]), 0.0, 10.0)
