"""The ground truth of a backend, and what moved by it."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.evaluation.trials.rig import build_rig
from handcart.evaluation.truth.survey import simulated_world
from handcart.evaluation.truth.true_changes import moved
from handcart.robotics.geometry.pose2 import Pose2


def test_it_is_the_same_through_all_that_is_put_around_a_backend() -> None:
    with build_rig() as rig:
        inner: Any = rig.backend
        layered = FaultyBackend(FaultyBackend(inner))
        one, other = inner.ground_truth(), layered.ground_truth()
        assert other is not None
        assert moved(one, other) == dict.fromkeys(moved(one, one), 0.0)
        assert simulated_world(layered) is inner.scene
        assert inner.scene is not None
        inner.scene.base = one.base.compose(Pose2(0.1, 0.0, 0.0))
        now = layered.ground_truth()
        assert now is not None
        assert moved(one, now)["base mm"] == pytest.approx(100.0)  # and `one` is as it was
