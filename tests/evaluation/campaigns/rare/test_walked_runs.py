"""Walks that are split, against the exact figures of the network."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks.campaigns.tosses import rare_walk
from handcart.evaluation.campaigns.data.walked_trials import network_trials
from handcart.evaluation.campaigns.rare.rare_event import RareEvent
from handcart.evaluation.campaigns.rare.rare_trial import walked_population
from handcart.evaluation.campaigns.statistics.exact_value import exact_end

POPULATIONS = 1500


@pytest.mark.slow
@pytest.mark.parametrize(
    ("outcome", "importance", "at_once"),
    [
        ("GiveUp", "fails", 0.0),
        ("GiveUp", "attempts", 0.0),
        ("GiveUp", "fails", 0.004),
        ("Fail", "fails", 0.0),
        ("Fail", "attempts", 0.0),
        ("Success", "fails", 0.0),
    ],
)
def test_the_mean_of_many_is_the_exact_value(
    tmp_path: Path, outcome: str, importance: str, at_once: float
) -> None:
    path = rare_walk(tmp_path, at_once)
    exact = exact_end(path, {}, outcome)
    assert isinstance(exact, float)
    trials, event = network_trials(path, {}), RareEvent.of(outcome, importance, 50)
    found = [
        walked_population(trials, event, seed).summary["metrics"]["probability"]
        for seed in range(POPULATIONS)
    ]
    sigma = float(np.std(found, ddof=1)) / math.sqrt(POPULATIONS)
    assert sigma < 0.2 * exact  # else this test says little
    assert abs(np.mean(found) - exact) < 4 * sigma


def test_a_population_is_the_same_for_the_same_seed(tmp_path: Path) -> None:
    trials, event = network_trials(rare_walk(tmp_path), {}), RareEvent.of("GiveUp")
    one, again, other = (walked_population(trials, event, seed) for seed in (3, 3, 4))
    assert one == again
    assert one.summary["metrics"] != other.summary["metrics"]
