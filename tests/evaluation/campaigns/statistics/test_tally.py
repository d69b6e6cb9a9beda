"""Counts of trials, to the number: outcomes, causes, metrics, and which trials are named first."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import parse

import pytest

from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial, died
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
from handcart.evaluation.campaigns.statistics.claim import Settling
from handcart.evaluation.campaigns.statistics.comparison import compare
from handcart.evaluation.campaigns.statistics.divergence import first_difference
from handcart.evaluation.campaigns.statistics.junit import write_junit
from handcart.evaluation.campaigns.statistics.tally import WORST_TRIAL_COUNT, Blame, Tally, in_general

DRIVE, PUSH = "MOVE_TO (a to b)", "INSERT (b to c)"


def trial(
    seed: int, time: float = 10.0, status: int = 0, reason: str = "", fails: int = 0, **metrics: Any
) -> Trial:
    """A drive and a push that ends as the trial does."""
    outcome = {0: "Success", 3: "Fail", 4: "GiveUp", 5: "Error"}[status]
    ends = [
        ActionEnd(DRIVE, "a", "b", "Success", 5.0),
        *[ActionEnd(PUSH, "b", "c", "Fail", 6.0, "4.5 mm off", "effect")] * fails,
        ActionEnd(PUSH, "b", "c", outcome, 9.0, reason, "" if status == 0 else "watch"),
    ]
    summary = {"outcome": outcome, "reason": reason, "metrics": metrics, "seed": seed, "run_dir": ""}
    return Trial(seed, status, {**summary, "sim_time_s": time, "actions": len(ends), "fails": fails}, ends)


TRIALS = [
    trial(0, 12.0, error_mm=1.0, fits=True),
    trial(1, 10.0, error_mm=3.0, fits=False, fails=2),
    trial(2, 99.0, 3, "8 mm off", error_mm=2.0, fits=True),
    trial(3, 11.0, untrue=["MOVE_TO: 60 mm off"], error_mm=float("nan")),
    trial(4, 98.0, 4, "hand is empty"),
    trial(5, 97.0, 3, "9.25 mm off", fails=1),
]


def test_outcomes_and_causes_are_counted_without_their_numbers() -> None:
    tally = Tally(TRIALS)
    assert (tally.count, tally.successes, tally.untrue) == (6, 3, [3])
    assert tally.outcomes == {"Success": 3, "Fail: # mm off": 2, "GiveUp: hand is empty": 1}
    assert tally.actions[DRIVE] == Counter(Success=6)
    assert tally.actions[PUSH] == Counter(Success=3, Fail=5, GiveUp=1)
    assert tally.blames == {
        Blame("INSERT", "Fail", "effect", "# mm off"): 3,
        Blame("INSERT", "Fail", "watch", "# mm off"): 2,
        Blame("INSERT", "GiveUp", "watch", "hand is empty"): 1,
    }


def test_metrics_are_numbers_that_are_finite_and_yes_or_no() -> None:
    tally = Tally(TRIALS)
    assert {name: list(values) for name, values in tally.columns.items()} == {
        "error_mm": [1.0, 3.0, 2.0],
        "fits": [1.0, 0.0, 1.0],
        "sim_time_s": [12.0, 10.0, 99.0, 11.0, 98.0, 97.0],
        "actions": [2.0, 4.0, 2.0, 2.0, 2.0, 3.0],
        "fails": [0.0, 2.0, 0.0, 0.0, 0.0, 1.0],
    }
    assert tally.yes_no == {"fits"}


def test_a_trial_whose_process_died_has_no_figures() -> None:
    """It counts as a trial, but not as one of 0 s without any action."""
    dead = died(6, "its process died 5 times, at last by signal 9")
    alone, both = CampaignReport(TRIALS), CampaignReport([*TRIALS, dead])
    assert both.spreads() == alone.spreads()
    assert (len(both.trials), both.successes) == (7, 3)
    assert both.outcomes["Error: its process died # times, at last by signal #"] == 1
    found = compare(TRIALS, [*TRIALS[:5], died(5, "its process died 5 times")])
    assert (found.pairs, [change.name for change in found.changes]) == (6, ["success"])
    broken = trial(6, 41.0, 5, "TypeError: ours")
    broken = Trial(6, 5, {**broken.summary, "run_dir": "runs/6"}, broken.actions)
    assert CampaignReport([*TRIALS, broken]).spreads()["sim_time_s"].count == 7


def test_handcart_s_own_faults_make_a_campaign_faulty() -> None:
    assert not CampaignReport([trial(0), trial(1, status=3, reason="8 mm off")]).faulty
    assert CampaignReport([trial(0), trial(1, untrue=["MOVE_TO: 60 mm off"])]).faulty
    assert CampaignReport([trial(0), trial(1, status=5, reason="TypeError: ours")]).faulty
    assert CampaignReport([trial(0), died(1, "its process died 5 times")]).faulty


def test_the_median_run_is_of_those_that_succeeded() -> None:
    assert Tally(TRIALS).median_run == 3
    assert Tally(TRIALS[:2]).median_run == 1
    assert Tally(TRIALS[4:]).median_run is None
    assert Tally([trial(0, 7.0), trial(1, 7.0), trial(2, 7.0)]).median_run == 1


def test_untrue_trials_are_named_first_then_fails_then_detours() -> None:
    report = CampaignReport(TRIALS)
    assert [trial_.seed for trial_ in report.worst()] == [3, 5, 2, 4, 1]
    assert [trial_.seed for trial_ in report.worst(2)] == [3, 5]
    many = [trial(seed, status=3, fails=seed % 3) for seed in range(40)]
    named = [trial_.seed for trial_ in CampaignReport(many).worst()]
    assert named == [seed for seed in range(40) if seed % 3 == 2][:WORST_TRIAL_COUNT]


def test_spreads_have_the_quantiles_of_their_metric() -> None:
    spread = CampaignReport([trial(seed, 10.0 + seed) for seed in range(101)]).spreads()["sim_time_s"]
    assert (spread.count, spread.least, spread.median, spread.most_95, spread.most) == (101, 10, 60, 105, 110)
    assert spread.mean == 60.0
    assert (spread.low, spread.high) == (50.0, 70.0)
    fits = CampaignReport(TRIALS).spreads()["fits"]
    assert fits.count == 3
    assert fits.mean == pytest.approx(2 / 3)
    assert fits.low == pytest.approx(0.2077, abs=1e-4)
    assert CampaignReport(TRIALS).spreads()["error_mm"].low is None


def test_shares_of_actions_and_their_causes_by_frequency() -> None:
    report = CampaignReport(TRIALS)
    push = report.shares[1]
    assert (push.action, push.success, push.fail, push.give_up, push.attempts) == (PUSH, 3, 5, 1, 9)
    assert push.p == pytest.approx(1 / 3)
    assert [times for _, times in report.blames] == [3, 2, 1]
    assert [item.seed for item in report.untrue] == [3]
    assert report.wilson == pytest.approx((0.1876, 0.8124), abs=1e-4)


@pytest.mark.parametrize(
    ("reason", "general"),
    [
        ("4.5 mm off", "# mm off"),
        ("-3e-05 rad, 2.1 s", "# rad, # s"),
        ("shelf2 is in joint_3", "shelf2 is in joint_3"),
        ("90 of 100", "# of #"),
    ],
)
def test_reasons_lose_measured_numbers_and_keep_names(reason: str, general: str) -> None:
    assert in_general(reason) == general


def test_the_first_difference_is_named_by_its_number_from_one() -> None:
    assert first_difference(TRIALS[0], trial(9, 50.0)) is None
    found = first_difference(TRIALS[0], TRIALS[2])
    assert found is not None
    assert found.number == 2
    assert found.words("A", "B") == (f"differs first in action 2: A {PUSH} Success; B {PUSH} Fail: 8 mm off")
    assert found.kind == f"{PUSH} Success against {PUSH} Fail"
    shorter = Trial(0, 0, TRIALS[0].summary, TRIALS[0].actions[:1])
    ended = first_difference(TRIALS[0], shorter)
    assert ended is not None
    assert (ended.number, ended.kind) == (2, f"{PUSH} Success against the end")
    assert ended.words("A", "B").endswith("B has ended")


def test_junit_counts_trials_failures_and_errors(tmp_path: Path) -> None:
    trials = [*TRIALS, trial(6, 1.25, 5, "a fault\x00 in here")]
    write_junit(tmp_path / "all.xml", "walk", trials, None)
    suite = parse(tmp_path / "all.xml").getroot()
    assert dict(suite.attrib) == {"name": "walk", "tests": "7", "failures": "4", "errors": "1"}
    cases = suite.findall("testcase")
    assert [case.get("time") for case in cases[:2]] == ["12.000", "10.000"]
    assert [len(case) for case in cases] == [0, 0, 1, 1, 1, 1, 1]
    assert [case[0].get("message") for case in cases[2:]] == [
        "Fail: 8 mm off",
        "MOVE_TO: 60 mm off",
        "GiveUp: hand is empty",
        "Fail: 9.25 mm off",
        "a fault  in here",
    ]


def test_junit_of_a_claim_forgives_fails_and_never_false_outcomes(tmp_path: Path) -> None:
    trials = [*TRIALS[:-1], trial(5, 97.0, 3, "9.25 mm\x1b off", fails=1)]
    settling = Settling.heard("p > 0.9", range(6), trials)
    write_junit(tmp_path / "claim.xml", "walk", trials, settling)
    suite = parse(tmp_path / "claim.xml").getroot()
    assert dict(suite.attrib) == {"name": "walk", "tests": "7", "failures": "2", "errors": "0"}
    said = [item.text for item in suite.iter("system-out")]
    assert said == ["Fail: 8 mm off", "GiveUp: hand is empty", "Fail: 9.25 mm  off"]


def test_pairs_are_matched_by_seed_whichever_is_missing() -> None:
    one = [trial(seed, 10.0) for seed in (0, 2, 3, 5, 8)]
    other = [trial(seed, 10.0 + seed, 3 if seed == 8 else 0) for seed in (1, 2, 4, 5, 6, 8)]
    found = compare(one, other)
    assert (found.pairs, found.unpaired, found.only_one, found.only_other) == (3, 5, 1, 0)
    assert found.success.mean == pytest.approx(-1 / 3)
    time = next(change for change in found.changes if change.name == "sim_time_s")
    assert time.pairs == 3
    assert time.mean == pytest.approx((2 + 5 + 8) / 3)
    assert [parting.seeds for parting in found.partings.values()] == [[8]]
