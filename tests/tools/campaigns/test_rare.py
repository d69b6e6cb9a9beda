"""`handcart campaign --rare`: ends that are too rare to count."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import orjson
import pytest

from benchmarks.campaigns.tosses import rare_walk
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.data.trial import died
from tests.tools.conftest import Said

ALWAYS = ("--level", "network", "--rare", "GiveUp", "--trials", 30)


def test_what_is_told(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("campaign", rare_walk(tmp_path), *ALWAYS)
    assert said.status == 0, said.err
    assert "handcart check computes 0.000113: they agree" in said.out
    assert "GiveUp: 0.000" in said.out
    assert "30 populations of 100 runs at each level" in said.out
    facts = orjson.loads(handcart("campaign", tmp_path / "walk.yaml", *ALWAYS, "--json").out)
    low, high = facts["interval"]
    assert low < facts["exact"]["p"] < high
    assert low < facts["probability"] < high
    assert facts["worth_runs"] > 10 * facts["cost_runs"]
    assert facts["levels"][0]["runs"] == 3000
    assert sum(level["adds"] for level in facts["levels"]) == pytest.approx(facts["probability"], rel=0.2)


@pytest.mark.slow
def test_parts_and_processes_tell_the_same(handcart: Callable[..., Said], tmp_path: Path) -> None:
    words = ("campaign", rare_walk(tmp_path), *ALWAYS[:-1], 6)
    plain = handcart(*words)
    whole = handcart(*words, "--out", tmp_path / "whole", "--jobs", 2)
    assert (plain.out, plain.status) == (whole.out, 0)
    again = handcart(*words, "--out", tmp_path / "whole")
    assert (again.out, "6 of 6 trials are there already" in again.err) == (whole.out, True)
    for part in (1, 2):
        handcart(*words, "--out", tmp_path / f"part{part}", "--shard", f"{part}/2")
    merged = handcart("campaign", "merge", tmp_path / "part1", tmp_path / "part2", "--out", tmp_path / "all")
    assert (merged.out, merged.status) == (whole.out, 0)
    other = handcart(*words, "--out", tmp_path / "whole", "--population", 50)
    assert (other.status, "rare runs: 100 there, 50 now" in other.err) == (2, True)


def test_populations_whose_process_died_are_left_out_and_named(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    words = ("campaign", rare_walk(tmp_path), *ALWAYS[:-1], 6, "--out", tmp_path / "part", "--shard", "1/1")
    whole = orjson.loads(handcart(*words, "--json").out)
    kept = CampaignFolder.read(tmp_path / "part")
    arguments = {key: value for key, value in kept.arguments.items() if key != "format"}
    trials = list(kept.trials())
    with CampaignFolder.made(tmp_path / "dead", arguments).log() as log:
        log.append([*trials[:5], died(5, "its process died 5 times")])
    said = handcart("campaign", "merge", tmp_path / "dead")
    assert said.status == 5, said.err
    assert "left out, because handcart itself failed: 1 populations" in said.out
    assert "  seed 5: its process died 5 times" in said.out
    assert "5 populations of 100 runs at each level" in said.out
    facts = orjson.loads(handcart("campaign", "merge", tmp_path / "dead", "--json").out)
    assert (facts["trials"], facts["broken"]) == (6, ["seed 5: its process died 5 times"])
    assert 0 < facts["levels"][0]["runs"] == whole["levels"][0]["runs"] * 5 / 6


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        (("--rare", "Giveup"), "did you mean 'GiveUp'? allowed: Success, Fail, GiveUp"),
        (("--rare", "Fail", "--importance", "fail"), "did you mean 'fails'? allowed: fails, attempts"),
        (("--rare", "Fail", "--population", "1"), "--population 1; allowed: 2 to"),
        (("--population", "20"), "--importance, --population; needed: --rare with them"),
        (("--importance", "fails"), "--importance, --population; needed: --rare with them"),
        (("--rare", "Fail", "--until", "p > 0.5"), "--rare --until; allowed: one of them"),
        (("--rare", "Fail", "--faults", "f.yaml"), "--rare --faults; allowed: one of them"),
        (("--rare", "Fail", "--vary", "v.yaml"), "--rare --vary; allowed: one of them"),
        (("--rare", "Fail", "--generate", "library"), "--rare --generate; allowed: one of them"),
        (("--rare", "Fail", "--first", "-1"), "--rare --first -1; allowed: 0 and more"),
        (
            ("--first", str(2**63 - 19)),
            "the last trial's seed 9223372036854775808; allowed: -9223372036854775808",
        ),
        (
            ("--rare", "Fail", "--level", "fitted", "--learned-from", "x"),
            "--rare --level fitted; allowed: run, network",
        ),
    ],
)
def test_what_cannot_be_is_refused(
    handcart: Callable[..., Said], tmp_path: Path, words: tuple[str, ...], wrong: str
) -> None:
    said = handcart("campaign", rare_walk(tmp_path), *words)
    assert (said.status, wrong in said.err, said.out) == (2, True, ""), said.err
    assert "Traceback" not in said.err


def test_populations_are_no_runs_to_compare(handcart: Callable[..., Said], tmp_path: Path) -> None:
    task = rare_walk(tmp_path)
    handcart("campaign", task, *ALWAYS[:-1], 2, "--out", tmp_path / "seldom")
    words = "seldom: its trials are populations that were asked for a rare end"
    for asked in (
        ("campaign", "compare", tmp_path / "seldom", tmp_path / "seldom"),
        ("campaign", task, "--level", "fitted", "--learned-from", tmp_path / "seldom"),
        ("report", tmp_path / "seldom"),
    ):
        said = handcart(*asked)
        assert (said.status, words in said.err) == (2, True), said.err
