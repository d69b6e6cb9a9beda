"""Estimate of a rare probability from several populations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import pytest
from scipy.stats import binom

from benchmarks.campaigns.tosses import rare_walk
from handcart.evaluation.campaigns.data.trial import Trial, died
from handcart.evaluation.campaigns.data.walked_trials import network_trials
from handcart.evaluation.campaigns.rare.rare_estimate import RareEstimate, interval
from handcart.evaluation.campaigns.rare.rare_event import NoRareEvent, RareEvent
from handcart.evaluation.campaigns.rare.rare_trial import walked_population
from handcart.evaluation.campaigns.statistics.exact_value import exact_end


def trial(*levels: Sequence[int]) -> Trial:
    return Trial(0, 0, {"metrics": {"levels": [list(level) for level in levels]}})


def test_levels_are_added_up() -> None:
    found = RareEstimate.of([trial((10, 1, 0, 10), (10, 0, 2, 10)), trial((10, 0, 0, 10))])
    assert found.probability == pytest.approx(0.01)
    assert [(level.share, level.runs, level.reached, level.hits) for level in found.levels] == [
        (1.0, 20, 1, 0),
        (0.05, 10, 0, 2),
    ]
    assert sum(level.part for level in found.levels) == pytest.approx(0.01)
    assert found.steps == 30
    assert found.cost == pytest.approx(30 / 1.05)
    assert found.unseen == pytest.approx(1.0 - 0.05 ** (1 / 20))  # none came straight from the beginning


def test_none_and_one_bound_nothing() -> None:
    nothing = RareEstimate.of([trial((10, 0, 0, 10))] * 3)
    assert (nothing.probability, nothing.low, nothing.high, nothing.worth) == (0.0, None, None, 0.0)
    assert binom.cdf(0, 30, nothing.unseen) == pytest.approx(0.05)
    assert nothing.agrees(0.09)
    assert not nothing.agrees(0.11)
    assert RareEstimate.of([trial((10, 0, 1, 10))]).low is None
    assert RareEstimate.of([]).probability == 0.0


def test_a_population_whose_process_died_is_left_out() -> None:
    trials = [trial((10, 0, 1, 10)), trial((10, 0, 3, 10))]
    kept, both = RareEstimate.of(trials), RareEstimate.of([*trials, died(7, "its process died 5 times")])
    assert both == kept


def test_the_interval_is_of_the_logarithm() -> None:
    low, high = interval(1e-4, 2e-5, 11) or (0.0, 0.0)
    assert low * high == pytest.approx(1e-8)
    assert math.log(high / 1e-4) == pytest.approx(2.228 * 0.2, rel=1e-3)  # Student's, 10 degrees


def test_the_interval_of_a_probability_ends_at_one() -> None:
    found = RareEstimate.of([trial((10, 0, 2, 10)), trial((10, 0, 0, 10))])
    assert found.low is not None
    assert found.low < found.probability == pytest.approx(0.1)
    assert found.high == 1.0


@pytest.mark.slow
def test_intervals_hold_the_exact_value_as_often_as_they_say(tmp_path: Path) -> None:
    path = rare_walk(tmp_path)
    exact, trials = exact_end(path, {}, "GiveUp"), network_trials(path, {})
    assert isinstance(exact, float)
    event, count = RareEvent.of("GiveUp"), 150
    inside = 0
    for number in range(count):
        seeds = range(20 * number, 20 * (number + 1))
        inside += RareEstimate.of(walked_population(trials, event, seed) for seed in seeds).agrees(exact)
    assert binom.cdf(inside, count, 0.95) > 1e-3
    assert inside < count  # an interval that always holds it says nothing


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        (("Giveup",), "--rare Giveup: no such one; did you mean 'GiveUp'? allowed: Success, Fail, GiveUp"),
        (("Cancelled",), "--rare Cancelled: no such one; allowed"),
        (
            ("GiveUp", "fail"),
            "--importance fail: no such one; did you mean 'fails'? allowed: fails, attempts",
        ),
        (("GiveUp", "fails", 1), "--population 1; allowed: 2 to 1000000 runs"),
    ],
)
def test_what_is_no_rare_event_is_refused(words: tuple[str, ...], wrong: str) -> None:
    with pytest.raises(NoRareEvent, match=wrong.replace("?", r"\?")):
        RareEvent.of(*words)  # type: ignore[arg-type]
