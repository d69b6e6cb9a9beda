"""Walks counted thousands at once, against the same walks one by one, and the exact figures."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.walked_trials import WalkedSequence, network_trials
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
from handcart.evaluation.campaigns.statistics.exact_value import exact_goal
from handcart.evaluation.campaigns.statistics.tally import Tally
from handcart.evaluation.campaigns.statistics.walk_tally import WalkTally


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [range(6000), range(4090, 4100), range(-5000, -10), range(7, 8)])
def test_it_counts_what_the_trials_count_one_by_one(tmp_path: Path, seeds: range) -> None:
    trials = network_trials(walk(tmp_path, 0.5), {})
    walks = WalkedSequence(trials, seeds)
    whole, each = WalkTally(trials, seeds), Tally(walks)
    assert sum(whole.count_all()) == len(seeds) == whole.count
    kinds = Counter[str]()
    for outcome, times in whole.outcomes.items():
        kinds[outcome.partition(":")[0]] += times
    assert kinds == Counter(trial.summary["outcome"] for trial in walks)
    assert whole.successes == sum(trial.success for trial in walks)
    for name in ("successes", "outcomes", "untrue", "yes_no", "actions", "blames", "worst", "timed"):
        assert getattr(whole, name) == getattr(each, name), name
    assert list(whole.actions) == list(each.actions)
    assert whole.columns.keys() == each.columns.keys()
    for name, values in whole.columns.items():
        assert np.allclose(values, each.columns[name]), name
    assert whole.median_run == each.median_run


def test_a_seed_s_walk_is_the_same_whichever_others_are_asked_for(tmp_path: Path) -> None:
    trials = network_trials(walk(tmp_path, 0.5), {})
    some = WalkedSequence(trials, range(8000, 8200))
    assert some[100:][50] == some[150] == trials.trial(8150) != trials.trial(8151)
    assert [item.seed for item in some[10:13]] == [8010, 8011, 8012]


def test_a_hundred_thousand_walks_fit_the_exact_value(tmp_path: Path) -> None:
    path = walk(tmp_path)
    trials, count = network_trials(path, {}), 100_000
    tally = WalkTally(trials, range(count))
    assert sum(tally.count_all()) == count
    exact = exact_goal(path, {})
    assert isinstance(exact, float)
    report = CampaignReport(WalkedSequence(trials, range(count)), counted=tally)
    sigma = math.sqrt(exact * (1.0 - exact) / count)
    assert abs(report.successes / count - exact) < 4.0 * sigma
    assert not report.worst()[0].success
    assert report.median_run is not None
    assert report.median_run.success
