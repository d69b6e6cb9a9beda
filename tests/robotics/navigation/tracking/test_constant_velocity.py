"""Kalman filters of bodies at constant velocity: consistency by NEES, gating, assignment."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from handcart.robotics.navigation.tracking.constant_velocity import assign, correct, predict

DT, DENSITY, SIGMA_M = 0.05, 0.15, 0.1
RUNS, PERIODS = 60, 60


def test_filter_of_matching_noise_has_the_expected_nees() -> None:
    rng = np.random.default_rng(3)
    chol = np.linalg.cholesky(predict(np.zeros((1, 4)), np.zeros((1, 4, 4)), DT, DENSITY)[1][0])
    truth = np.column_stack([rng.uniform(-5, 5, (RUNS, 2)), rng.normal(0.0, 1.0, (RUNS, 2))])
    means = np.column_stack([truth[:, :2] + SIGMA_M * rng.standard_normal((RUNS, 2)), np.zeros((RUNS, 2))])
    covariances = np.tile(np.diag([SIGMA_M**2, SIGMA_M**2, 1.0, 1.0]), (RUNS, 1, 1))
    noises = np.tile(SIGMA_M**2 * np.eye(2), (RUNS, 1, 1))
    F = np.eye(4) + DT * np.eye(4, k=2)
    found = []
    for period in range(PERIODS):
        truth = truth @ F.T + rng.standard_normal((RUNS, 4)) @ chol.T
        means, covariances = predict(means, covariances, DT, DENSITY)
        measured = truth[:, :2] + SIGMA_M * rng.standard_normal((RUNS, 2))
        means, covariances = correct(means, covariances, measured, noises)
        if period % 20 == 19:  # errors of one body are correlated in time
            off = means - truth
            found.append(np.einsum("ni,ni->n", off, np.linalg.solve(covariances, off[..., None])[..., 0]))
    total, count = float(np.sum(found)), np.size(found)
    low, high = chi2.ppf([0.001, 0.999], 4 * count)
    assert low < total < high


def test_crossing_bodies_are_assigned_all_together() -> None:
    means = np.array([[0.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0]])
    covariances, noises = np.tile(0.05 * np.eye(4), (2, 1, 1)), np.tile(0.01 * np.eye(2), (2, 1, 1))
    measured = np.array([[0.3, 0.0], [-0.2, 0.0]])  # the nearest of the first body is the second one's
    assert sorted(assign(means, covariances, measured, noises)) == [(0, 1), (1, 0)]


def test_measurement_beyond_the_gate_belongs_to_nobody() -> None:
    means, covariances = np.zeros((1, 4)), 0.01 * np.eye(4)[None]
    noises = 0.01 * np.eye(2)[None]
    assert assign(means, covariances, np.array([[0.6, 0.0]]), noises) == []
    assert assign(means, covariances, np.array([[0.2, 0.0]]), noises) == [(0, 0)]
    assert assign(np.empty((0, 4)), np.empty((0, 4, 4)), np.zeros((1, 2)), noises) == []
