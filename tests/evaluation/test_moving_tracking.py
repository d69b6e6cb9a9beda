"""Tracking from a moving base, for comparison."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.seam.moving_tracking import Feedback, MovingTracking, Straying
from handcart.backends.description.robot_loading import load_robot
from handcart.primitives.seam.seam_file import load_seam
from handcart.robotics.manipulation.tracking.tool_path import ToolPath

pytestmark = pytest.mark.slow

SEAM = Path(__file__).parents[2] / "tasks" / "track_seam" / "seam.csv"
FAST = Feedback(20.0, 0.005, 200.0)


@pytest.fixture(scope="module")
def seam() -> ToolPath:
    """1 m of the shipped one."""
    whole = load_seam(SEAM)
    return whole.part(150, 250)


@pytest.fixture(scope="module")
def tracking(seam: ToolPath) -> MovingTracking:
    return MovingTracking(load_robot("atrv"), seam)


def test_a_base_that_does_not_stray_leaves_the_arms_own_error(seam: ToolPath) -> None:
    still = MovingTracking(load_robot("atrv"), seam, Straying(position=0.0, heading=0.0))
    assert still.run(0).errors.max() < 0.0015
    exact = MovingTracking(load_robot("atrv").without_errors(), seam, Straying(position=0.0, heading=0.0))
    assert exact.run(0).errors.max() < 1e-5


def test_feedback_takes_most_of_the_error_away(tracking: MovingTracking) -> None:
    runs = [(tracking.run(seed), tracking.run(seed, FAST)) for seed in range(3)]
    blind, corrected = (np.median([run.errors.max() for run in each]) for each in zip(*runs, strict=True))
    assert 0.008 < blind < 0.04
    assert corrected < 0.2 * blind
    assert max(run.speed_use for pair in runs for run in pair) < 1.0


def test_a_slower_arm_and_later_readings_are_worse(tracking: MovingTracking) -> None:
    slow, fast = (
        np.sqrt(np.mean([np.mean(tracking.run(seed, how).errors ** 2) for seed in range(2)]))
        for how in (Feedback(5.0, 0.02, 50.0), FAST)
    )
    assert slow > 1.3 * fast


def test_the_same_seed_is_the_same_run(tracking: MovingTracking) -> None:
    run = tracking.run(5)
    assert np.array_equal(run.errors, tracking.run(5).errors)
    assert not np.array_equal(run.errors, tracking.run(6).errors)
