"""A track that is smoothed as it comes, against all states and readings at once."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors.smoothing import TrackRecord

STEP = np.array([[1.0, 0.4, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.0, 1.0]])
NOISE = np.diag([0.05, 0.02, 0.0])
ROW = np.array([[1.0, 0.0, 0.5]])
VARIANCE = 0.3
PRIOR = np.array([[1.0, 0.2, 0.0], [0.2, 0.5, 0.1], [0.0, 0.1, 0.4]])
READINGS = (0.7, -0.4, 1.1, 0.2, -0.9, 0.5)
WANTED = (0, 2, 3, 6)


def all_at_once() -> list[Belief]:
    """Each state by all readings: the conditional of one normal distribution of all of them."""
    count = len(READINGS) + 1
    spread = np.zeros((3 * count, 3 * count))
    spread[:3, :3] = PRIOR
    for k in range(1, count):
        now, before = slice(3 * k, 3 * k + 3), slice(3 * k - 3, 3 * k)
        spread[now, : 3 * k] = STEP @ spread[before, : 3 * k]
        spread[: 3 * k, now] = spread[now, : 3 * k].T
        spread[now, now] = STEP @ spread[before, before] @ STEP.T + NOISE
    rows = np.zeros((len(READINGS), 3 * count))
    for k in range(1, count):
        rows[k - 1, 3 * k : 3 * k + 3] = ROW
    gain = spread @ rows.T @ np.linalg.inv(rows @ spread @ rows.T + VARIANCE * np.eye(len(READINGS)))
    mean, after = gain @ np.array(READINGS), spread - gain @ rows @ spread
    return [Belief(mean[3 * k : 3 * k + 3], after[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]) for k in WANTED]


def filtered(record: TrackRecord) -> None:
    mean, spread = np.zeros(3), PRIOR
    for k, reading in enumerate((None, *READINGS)):
        if reading is not None:
            mean, spread = STEP @ mean, STEP @ spread @ STEP.T + NOISE
            record.step(STEP)
            residual = np.array([reading]) - ROW @ mean
            record.correct(spread, ROW, residual, VARIANCE)
            gain = spread @ ROW.T / (ROW @ spread @ ROW.T + VARIANCE)
            mean, spread = mean + gain @ residual, spread - gain @ ROW @ spread
        if k in WANTED:
            record.mark(Belief(mean, spread))


def test_smoothed_moments_are_what_all_readings_tell_at_once() -> None:
    record = TrackRecord()
    record.start()
    filtered(record)
    for found, wanted in zip(record.smoothed(), all_at_once(), strict=True):
        assert found.mean == pytest.approx(wanted.mean, abs=1e-6)
        assert found.covariance == pytest.approx(wanted.covariance, abs=1e-6)


def test_nothing_is_carried_back_over_a_new_beginning() -> None:
    record = TrackRecord()
    record.start()
    filtered(record)
    first = record.smoothed()
    record.start()
    record.mark(Belief(np.full(3, 9.0), 1e-9 * np.eye(3)))
    again = record.smoothed()
    assert len(again) == len(first) + 1
    for one, other in zip(again, first, strict=False):
        assert one.mean == pytest.approx(other.mean)


def test_a_rewound_record_forgets_what_came_later() -> None:
    record = TrackRecord()
    record.start()
    filtered(record)
    kept, before = record.entries, record.smoothed()
    record.step(STEP)
    record.mark(Belief(np.full(3, 9.0), np.eye(3)))
    assert len(record.smoothed()) == len(before) + 1
    record.rewind(kept)
    for one, other in zip(record.smoothed(), before, strict=True):
        assert one.mean == pytest.approx(other.mean)
    record.start()
    with pytest.raises(ValueError, match="before the filter's restart"):
        record.rewind(kept)
