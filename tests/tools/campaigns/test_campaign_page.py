"""A campaign as one page: its contents, and that it loads nothing from outside."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.page.campaign_page import CampaignPage
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
from tests.browser import DESK, PHONE, axe_findings, browsing, needs_browser
from tests.tools.conftest import Said

ASKED: dict[str, Any] = {
    "task": "task.yaml",
    "backend": None,
    "settings": {},
    "generate": [],
    "first": 0,
    "trials": 10_000,
    "level": "run",
    "until": None,
    "shard": None,
    "handcart": "1",
}


def rows(page: str) -> list[str]:
    return page.partition("<tbody>")[2].partition("</tbody>")[0].strip().splitlines()


def network(tour: Path, p: float) -> Path:
    text = tour.read_text(encoding="utf-8")
    tour.write_text(text.replace("cost_s: 30", f"cost_s: 30, p: {p}, p_give_up: 0.1"), encoding="utf-8")
    return tour


@pytest.mark.slow
def test_page_equals_the_campaign_and_that_of_its_merged_parts(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    words = ("campaign", network(tour, 0.6), "--level", "network", "--trials", "60")
    said = handcart(*words, "--out", tmp_path / "whole")
    assert (said.status, "whole/report.html" in said.err) == (0, True)
    page = (tmp_path / "whole" / "report.html").read_text(encoding="utf-8")
    successes, low, high = re.findall(r"Success (\d+) of 60; by Wilson ([\d.]+) to ([\d.]+) %", said.out)[0]
    assert f"{successes} of 60 trials reached the goal" in page
    assert f"95 % interval {low} to {high} %" in page
    assert re.search(r"handcart check computes [\d.]+ %: they agree", page)
    assert len(rows(page)) == 60
    assert sum("<td>Success" in row for row in rows(page)) == int(successes)
    worst = re.findall(r"<pre>(handcart campaign .*)</pre>", page)
    assert worst == [line.strip() for line in said.out.splitlines() if line.startswith("  handcart ")]
    assert len(worst) == 10

    parts = [tmp_path / "1", tmp_path / "2"]
    for part in parts:
        assert handcart(*words, "--shard", f"{part.name}/2", "--out", part).status == 0
    assert handcart("campaign", "merge", *parts, "--out", tmp_path / "all").status == 0
    assert (tmp_path / "all" / "report.html").read_text(encoding="utf-8") == page

    assert handcart("report", tmp_path / "all", "-o", tmp_path / "again.html").status == 0
    assert (tmp_path / "again.html").read_text(encoding="utf-8") == page
    assert handcart(*words, "--no-report", "--out", tmp_path / "bare").status == 0
    assert not (tmp_path / "bare" / "report.html").exists()


def test_only_its_own_script_may_run_and_nothing_is_fetched(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    tour.write_text(tour.read_text(encoding="utf-8").replace("at_home", "<script>x</script>"), "utf-8")
    words = ("campaign", network(tour, 0.1), "--level", "network", "--trials", "9", "--out", tmp_path / "out")
    assert handcart(*words).status == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    allowed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert (
        f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{allowed}'" in page
    )
    assert "&lt;script&gt;x&lt;/script&gt;" in page
    assert not re.search(r'(?:src|href)="|url\((?!#)|@import|https?:', page)


def test_a_page_of_a_campaign_with_nothing_in_it(tmp_path: Path) -> None:
    folder = CampaignFolder.made(tmp_path / "out", ASKED)
    page = CampaignPage.of(folder.folder).write().read_text(encoding="utf-8")
    assert "no trial has ended yet" in page


def long_trial(seed: int) -> Trial:
    """Ends after many words, with many numbers."""
    reason = f"something stands {seed}.125 m ahead " + "of it, and leans on the shelf that is there " * 20
    metrics = {f"metric_{number}_mm": (seed * (number + 7) % 1009) / 7 for number in range(30)}
    summary = {"outcome": "Fail", "reason": reason, "sim_time_s": 0.1 * seed, "actions": 9, "fails": seed % 3}
    end = ActionEnd("MOVE_TO (here to there)", "here", "there", "Fail", 1.0, reason, "watch")
    run = f"/far/away/runs/return_book-{seed}"
    return Trial(seed, 3, {**summary, "metrics": metrics, "run_dir": run}, [end])


@pytest.mark.slow
def test_a_page_of_very_many_trials_stays_small(tmp_path: Path) -> None:
    folder = CampaignFolder.made(tmp_path / "out", ASKED)
    for seed in (0, 9_999):
        (folder.runs / f"return_book-{seed}").mkdir(parents=True)
    page = CampaignPage(folder, CampaignReport([long_trial(seed) for seed in range(10_000)]), None)
    content = page.write().read_bytes()
    assert len(content) <= 3 * 2**20
    listed = rows(content.decode())
    assert [re.findall(r'<a href="(.*?)">(\d+)<', row) for row in (listed[0], listed[-1])] == [
        [(f"runs/return_book-{seed}/", str(seed))] for seed in (0, 9_999)
    ]


@pytest.mark.slow
def test_long_trial_list_omits_those_that_succeeded(tmp_path: Path) -> None:
    folder = CampaignFolder.made(tmp_path / "out", {**ASKED, "trials": 10_100})
    plain = {"outcome": "Success", "reason": "", "sim_time_s": 1.0, "actions": 1, "fails": 0, "metrics": {}}
    trials = [Trial(seed, 0, plain) for seed in range(10_099)]
    trials.append(Trial(10_099, 4, {**plain, "outcome": "GiveUp", "reason": "it slips"}))
    page = CampaignPage(folder, CampaignReport(trials), None).write().read_text(encoding="utf-8")
    assert len(rows(page)) == 10_000
    assert "it slips" in rows(page)[-1]
    assert "100 more that reached the goal are left out" in page


@pytest.mark.slow
def test_trials_link_to_their_runs_also_in_merged_campaigns(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    """With Fails, so that a run is to be looked at first and has a page."""
    faults = tmp_path / "faults.yaml"
    faults.write_text("format: handcart-faults/1\nfaults:\n  - {kind: exception, at_s: 2.0}\n", "utf-8")
    words = ("campaign", tour, "--trials", "2", "--jobs", "1", "--faults", faults)
    for part in ("1", "2"):
        handcart(*words, "--shard", f"{part}/2", "--out", tmp_path / part)
    handcart("campaign", "merge", tmp_path / "1", tmp_path / "2", "--out", tmp_path / "all")
    handcart(*words, "--out", tmp_path / "whole")
    page = (tmp_path / "whole" / "report.html").read_text(encoding="utf-8")
    assert (tmp_path / "all" / "report.html").read_text(encoding="utf-8") == page
    links = re.findall(r'<a href="(.*?)">\d', page)
    assert links == [f"runs/tour-{seed}/report.html" for seed in (0, 1)]
    assert all((tmp_path / "all" / link).is_file() for link in links)


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize("size", [PHONE, DESK])
def test_axe_finds_nothing(tmp_path: Path, size: tuple[int, int]) -> None:
    """On a page with Fails, GiveUps, metrics and worst seeds."""
    folder = CampaignFolder.made(tmp_path / "out", {**ASKED, "trials": 40})
    page = CampaignPage(folder, CampaignReport([long_trial(seed) for seed in range(40)]), None).write()
    with browsing(size) as seen:
        seen.page.goto(page.resolve().as_uri())
        assert axe_findings(seen.page) == []
        assert seen.errors == []


def test_readers_of_a_campaign_name_a_damaged_last_line(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    words = ("campaign", network(tour, 0.6), "--level", "network", "--trials", "5")
    assert handcart(*words, "--no-report", "--out", folder).status == 0
    log = folder / "trials.jsonl"
    log.write_bytes(log.read_bytes()[:-20])
    size = len(log.read_bytes().rpartition(b"\n")[2])
    file = tmp_path / "trials.parquet"
    for command in (
        ("report", folder),
        ("campaign", "compare", folder, folder),
        ("export", folder, "-o", file),
    ):
        said = handcart(*command)
        assert said.status == 0, said.err
        assert f"{folder}: the last line of its log is damaged or being written ({size} bytes)" in said.err
