"""Two campaigns side by side."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.statistics.comparison import NoPairs, compare
from handcart.evaluation.campaigns.statistics.paired_tests import (
    e_value,
    holm,
    mcnemar,
    mcnemar_power,
    signed_rank,
    smallest_difference,
)
from tests.tools.conftest import Said
from tests.tools.conftest import handcart as handcart


def trial(seed: int, success: bool, time: float = 10.0) -> Trial:
    outcome, reason = ("Success", "") if success else ("Fail", "a wall")
    ends = [
        ActionEnd("MOVE_TO (a to b)", "a", "b", "Success", 5.0),
        ActionEnd("INSERT (b to c)", "b", "c", outcome, 9.0, reason),
    ]
    summary = {"outcome": outcome, "reason": reason, "metrics": {}, "seed": seed, "run_dir": ""}
    return Trial(seed, 0 if success else 3, {**summary, "sim_time_s": time, "actions": 2, "fails": 0}, ends)


def campaign(failed: Sequence[int], count: int = 40, first: int = 0, slower: float = 0.0) -> list[Trial]:
    return [trial(seed, seed not in failed, 10.0 + slower * (seed % 7)) for seed in range(first, count)]


def test_pairs_share_a_seed_and_the_first_difference_explains() -> None:
    found = compare(campaign([3]), campaign(range(10, 22), first=2))
    assert (found.pairs, found.unpaired, found.only_one, found.only_other) == (38, 2, 12, 1)
    assert found.worse
    assert found.success.p_value == pytest.approx(2 * 14 / 2**13)
    ((kind, parting), (_, back)) = found.partings.items()
    assert kind == "INSERT (b to c) Success against INSERT (b to c) Fail"
    assert (parting.times, parting.seeds, back.seeds) == (12, [10, 11, 12], [3])
    assert parting.example is not None
    assert parting.example.number == 2
    assert "B INSERT (b to c) Fail: a wall" in parting.example.words("A", "B")


def test_the_pair_that_made_it_sure_is_named() -> None:
    """Eight pairs in a row of which one alone succeeded are the first that chance doesn't explain."""
    assert e_value(7, 0) < 20.0 <= e_value(8, 0)
    assert compare(campaign([]), campaign(range(10, 22))).sure_at == 18
    assert compare(campaign(range(10, 22)), campaign([])).sure_at == 18
    assert compare(campaign([]), campaign(range(10, 17))).sure_at is None
    assert compare(campaign([]), campaign(range(0, 40, 2))).sure_at == 15


def test_campaigns_without_a_difference_prove_none() -> None:
    found = compare(campaign([3]), campaign([3]))
    assert [change.name for change in found.changes] == ["success"]
    assert (found.worse, found.success.adjusted, found.e_value, found.partings) == (False, 1.0, 1.0, {})
    with pytest.raises(NoPairs):
        compare(campaign([], 5), campaign([], 9, first=5))


def test_slower_campaign_is_detected_at_equal_success_rate() -> None:
    found = compare(campaign([]), campaign([], slower=0.3))
    time = found.changes[1]
    assert (time.name, time.proven, found.success.proven) == ("sim_time_s", True, False)
    assert time.mean == pytest.approx(0.3 * np.mean([seed % 7 for seed in range(40)]))


def test_the_bet_is_won_by_differences_alone() -> None:
    assert e_value(0, 0) == pytest.approx(1.0)
    assert e_value(8, 0) == pytest.approx(2**8 / 9)
    chance = np.random.default_rng(1)
    ever = 0
    for _ in range(2000):
        heads = np.cumsum(chance.random(100) < 0.5)
        ever += max(e_value(int(h), at + 1 - int(h)) for at, h in enumerate(heads)) >= 20.0
    assert ever / 2000 <= 0.05


@pytest.mark.slow
def test_power_is_that_of_drawn_campaigns() -> None:
    chance = np.random.default_rng(2)
    drawn = chance.multinomial(100, [0.05, 0.2, 0.75], 4000)
    cached = {tuple(item[:2]): mcnemar(int(item[0]), int(item[1])) <= 0.05 for item in drawn}
    seen = np.mean([cached[tuple(item[:2])] for item in drawn])
    assert mcnemar_power(0.15, 0.05, 100) == pytest.approx(seen, abs=0.025)


def test_the_smallest_difference_is_seen_four_times_of_five() -> None:
    least = smallest_difference(0, 0, 100)
    assert least is not None
    assert binom.sf(5, 100, least) == pytest.approx(0.8, abs=1e-3)  # six pairs are the first to be enough
    assert smallest_difference(0, 0, 5) is None


def test_holm_takes_the_most_telling_first() -> None:
    weights = dict.fromkeys("abc", 1.0)
    adjusted = holm({"a": 0.04, "b": 0.01, "c": 0.03}, weights)
    assert adjusted == pytest.approx({"b": 0.03, "c": 0.06, "a": 0.06})
    assert signed_rank(np.zeros(5)) == 1.0


@pytest.mark.parametrize(("failed", "status"), [(range(10, 22), 3), ([], 0)])
def test_the_command_ends_with_3_where_the_second_is_worse(
    handcart: Callable[..., Said], tmp_path: Path, failed: Sequence[int], status: int
) -> None:
    for name, trials in (("a", campaign([3])), ("b", campaign(failed))):
        with CampaignFolder.made(tmp_path / name, {"trials": 40}).log() as log:
            log.append(trials)
    said = handcart("campaign", "compare", tmp_path / "a", tmp_path / "b")
    assert (said.status, "B is worse" in said.out) == (status, status == 3)
    said = handcart("campaign", "compare", tmp_path / "a", tmp_path / "b", "--json")
    assert json.loads(said.out)["worse"] == (status == 3)
    said = handcart("campaign", "compare", tmp_path / "a", tmp_path / "c")
    assert said.status == 2
    assert "there is no campaign.json in it" in said.err
