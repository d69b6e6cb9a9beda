"""A past moment of which more is learned, against the filter that holds it as states of its own."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief, BeliefBranch, WatchedMoment
from handcart.robotics.navigation.outdoors.field_model import corrected

SIZE, KEPT = 4, 3
ROWS = np.array([[1.0, 0.0, 0.3, 0.0], [0.0, 1.0, 0.0, -0.2]])


def some_belief(rng: np.random.Generator) -> Belief:
    root = rng.standard_normal((SIZE, SIZE))
    return Belief(rng.standard_normal(SIZE), root @ root.T + np.eye(SIZE))


def doubled(belief: Belief) -> Belief:
    """States now, and the first of them as a clone."""
    pick = np.vstack([np.eye(SIZE), np.eye(SIZE)[:KEPT]])
    return Belief(pick @ belief.mean, pick @ belief.covariance @ pick.T)


def apart(states: np.ndarray) -> np.ndarray:
    """(3,) of the pose now in the frame of the cloned one."""
    now, then = Pose2(*states[:3].tolist()), Pose2(*states[SIZE:].tolist())
    x, y, _ = now.relative_to(then)
    return np.array([x, y, now.theta - then.theta])


def test_it_learns_what_a_filter_with_cloned_states_learns() -> None:
    """Steps and readings by turns; then and now, and what is between them, are the same."""
    rng = np.random.default_rng(0)
    now = some_belief(rng)
    whole, moment = doubled(now), WatchedMoment.of(now, KEPT)
    for _ in range(5):
        transition = np.eye(SIZE) + 0.2 * rng.standard_normal((SIZE, SIZE))
        added = 0.1 * np.eye(SIZE)
        now = Belief(transition @ now.mean, transition @ now.covariance @ transition.T + added)
        moment = moment.stepped(transition)
        both = np.eye(SIZE + KEPT)
        both[:SIZE, :SIZE] = transition
        whole = Belief(both @ whole.mean, both @ whole.covariance @ both.T)
        whole.covariance[:SIZE, :SIZE] += added
        residual = rng.standard_normal(2) - ROWS @ now.mean
        moment = moment.corrected(now.covariance, ROWS, residual, 0.5)
        rows = np.hstack([ROWS, np.zeros((2, KEPT))])
        now = Belief(*corrected(now.mean, now.covariance, ROWS, residual, 0.5))
        whole = Belief(*corrected(whole.mean, whole.covariance, rows, residual, 0.5))
    assert np.allclose(moment.belief.mean, whole.mean[SIZE:])
    assert np.allclose(moment.belief.covariance, whole.covariance[SIZE:, SIZE:])
    relative = moment.relative_pose(now)
    assert np.allclose(relative.mean, apart(whole.mean))
    nudges = 1e-6 * np.eye(len(whole.mean))
    J = np.array([(apart(whole.mean + nudge) - apart(whole.mean - nudge)) / 2e-6 for nudge in nudges]).T
    assert np.allclose(relative.covariance, J @ whole.covariance @ J.T, atol=1e-6)


def test_of_two_ways_that_are_the_same_it_learns_what_one_tells() -> None:
    rng = np.random.default_rng(1)
    now, residual = some_belief(rng), rng.standard_normal(2)
    moment = WatchedMoment.of(now, KEPT).stepped(np.eye(SIZE) * 0.9)
    mean, _ = corrected(now.mean, now.covariance, ROWS, residual, 0.5)
    one = moment.corrected(now.covariance, ROWS, residual, 0.5)
    branch = BeliefBranch(0.5, np.eye(SIZE), now.covariance, residual, mean)
    either = moment.corrected_either([branch, branch], ROWS, 0.5)
    for a, b in zip((*one.belief, one.shared), (*either.belief, either.shared), strict=True):
        assert np.allclose(a, b)


def test_after_a_new_beginning_nothing_cancels() -> None:
    now = some_belief(np.random.default_rng(2))
    moment = WatchedMoment.of(now, KEPT)
    assert np.allclose(moment.relative_pose(now).covariance, 0.0)
    unrelated = moment.unrelated().relative_pose(now).covariance
    assert np.allclose(np.trace(unrelated), 2.0 * np.trace(now.covariance[:3, :3]))
