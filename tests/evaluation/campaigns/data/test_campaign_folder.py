"""A campaign on disk: nothing is lost, nothing counts twice, nothing is mixed up."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder, NoCampaign, OtherCampaign
from handcart.evaluation.campaigns.data.merging import NotOneCampaign, merged
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.data.trial_log import CampaignAlive, TrialLog, TrialLogError
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport


def trial(seed: int, status: int = 0) -> Trial:
    outcome, reason = ("Success", "") if status == 0 else ("Fail", f"it stands {seed}.5 m ahead")
    why = "" if status == 0 else "blocked"
    summary: dict[str, Any] = {
        "outcome": outcome,
        "reason": reason,
        "metrics": {"far_mm": 0.1 * seed, "read": seed % 2 == 0},
    }
    summary |= {"sim_time_s": 10.0 + seed, "wall_time_s": 1.0, "actions": 1, "fails": int(status > 0)}
    end = ActionEnd(
        "MOVE_TO (here to there)", "here", "there", outcome, 10.0 + seed, reason, "watch", False, why
    )
    return Trial(seed, status, summary, [end])


def written(path: Path, seeds: Iterable[int]) -> bytes:
    with TrialLog(path) as log:
        for seed in seeds:
            log.append([trial(seed)])
    return path.read_bytes()


def test_trials_come_back_as_they_were_in_the_order_of_their_seeds(tmp_path: Path) -> None:
    written(tmp_path / "trials.jsonl", [5, 1, 3])
    with TrialLog(tmp_path / "trials.jsonl") as log:
        log.append([trial(1, 3), trial(2)])
        assert list(log.trials()) == [trial(seed) for seed in (1, 2, 3, 5)]
        assert log.trials()[1:3][1] == trial(3)
        assert (5 in log, 4 in log, len(log)) == (True, False, 4)


def test_wherever_it_was_cut_whole_trials_are_left(tmp_path: Path) -> None:
    """A crash while a line is written leaves any part of it."""
    path = tmp_path / "trials.jsonl"
    whole = written(path, range(3))
    begins = whole.index(b"\n", whole.index(b"\n") + 1) + 1
    for size in range(begins, len(whole)):
        path.write_bytes(whole[:size])
        with TrialLog(path, sync=False) as log:
            assert log.dropped_bytes == size - begins
            assert [item.seed for item in log.trials()] == [0, 1]
            log.append([trial(2)])
        assert path.read_bytes() == whole


def test_damaged_last_line_is_dropped_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    whole = written(path, range(2))
    last = whole[whole.index(b"\n") + 1 :]
    path.write_bytes(whole.replace(last, last.replace(b'"status":0', b'"status":3')))
    with TrialLog(path) as log:
        assert (len(log), log.dropped_bytes) == (1, len(last))
    with TrialLog(path) as log:
        assert (len(log), log.dropped_bytes) == (1, 0)


def test_a_line_that_was_changed_is_told(tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    whole = written(path, range(3))
    path.write_bytes(whole.replace(b'"status":0', b'"status":3', 1))
    with pytest.raises(TrialLogError, match="line 1 at byte 0 isn't what was written"):
        TrialLog(path)
    path.write_bytes(whole + whole[: whole.index(b"\n") + 1])
    with pytest.raises(TrialLogError, match="seed 0 is there twice"):
        TrialLog(path)


def test_two_cannot_write_one_campaign(tmp_path: Path) -> None:
    with TrialLog(tmp_path / "trials.jsonl"), pytest.raises(CampaignAlive):
        TrialLog(tmp_path / "trials.jsonl")


def test_other_arguments_are_refused_with_what_differs(tmp_path: Path) -> None:
    asked = {"trials": 5, "settings": {"tour": "[desk]"}, "files": {"world.yaml": "12"}, "task": "a.yaml"}
    CampaignFolder.made(tmp_path, asked)
    CampaignFolder.made(tmp_path, {**asked, "task": "/elsewhere/a.yaml"})
    with pytest.raises(OtherCampaign) as refused:
        CampaignFolder.made(tmp_path, {"trials": 6, "settings": {}, "files": {"world.yaml": "34"}})
    said = str(refused.value)
    assert "trials: 5 there, 6 now" in said
    assert "settings tour: [desk] there, nothing now" in said
    assert "world.yaml has another content" in said


@pytest.mark.parametrize("left", [{"notes.txt": "mine"}, {"campaign.json": "{"}, {"campaign.json": "[]"}])
def test_a_folder_of_something_else_is_left_alone(tmp_path: Path, left: dict[str, str]) -> None:
    for name, text in left.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(NoCampaign):
        CampaignFolder.made(tmp_path, {"trials": 5})
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == left


def test_a_campaign_that_was_killed_as_its_folder_was_made_goes_on(tmp_path: Path) -> None:
    (tmp_path / ".campaign.json.123.new").write_text("{", encoding="utf-8")
    assert CampaignFolder.made(tmp_path, {"trials": 5}).arguments["trials"] == 5
    assert len(CampaignFolder.read(tmp_path).trials()) == 0


def part(folder: Path, shard: str, seeds: Iterable[int], trials: int = 6) -> Path:
    whole = CampaignFolder.made(folder, {"trials": trials, "first": 0, "shard": shard})
    with whole.log() as log:
        log.append([trial(seed, 3 * (seed == 4)) for seed in seeds])
    return folder


def test_parts_are_merged_into_what_one_machine_has(tmp_path: Path) -> None:
    parts = [part(tmp_path / "1", "1/2", (4, 0, 2)), part(tmp_path / "2", "2/2", (1, 5, 3))]
    whole = merged(parts, tmp_path / "whole")
    assert list(whole.trials()) == [trial(seed, 3 * (seed == 4)) for seed in range(6)]
    assert (whole.arguments["shard"], CampaignReport(whole.trials()).successes) == (None, 5)


def test_a_merged_campaign_leads_to_the_runs_of_its_parts(tmp_path: Path) -> None:
    parts = [tmp_path / "1", tmp_path / "2"]
    for seed, folder in enumerate(parts):
        found = CampaignFolder.made(folder, {"trials": 2, "first": 0, "shard": f"{seed + 1}/2"})
        (found.runs / f"tour-{seed}").mkdir(parents=True)
        (found.runs / f"tour-{seed}" / "summary.json").write_text(str(seed), encoding="utf-8")
        ended = trial(seed)
        with found.log() as log:
            log.append([replace(ended, summary={**ended.summary, "run_dir": f"elsewhere/tour-{seed}"})])
    for _ in range(2):  # the second time all is there
        whole = merged(parts, tmp_path / "whole")
        assert [(whole.runs / f"tour-{seed}" / "summary.json").read_text("utf-8") for seed in (0, 1)] == [
            "0",
            "1",
        ]


def test_what_is_not_one_campaign_is_not_merged(tmp_path: Path) -> None:
    one, two = part(tmp_path / "1", "1/2", (0, 2, 4)), part(tmp_path / "2", "2/2", (1, 3))
    with pytest.raises(NotOneCampaign, match=r"1 of 6 trials are in none of the folders.*seed 5"):
        merged([one, two], tmp_path / "whole")
    with pytest.raises(NotOneCampaign, match="both hold the trial of seed 0"):
        merged([one, one, two], tmp_path / "whole")
    with pytest.raises(NotOneCampaign, match="trials: 6 there, 7 now"):
        merged([one, part(tmp_path / "3", "2/2", (1,), 7)], tmp_path / "whole")
    assert not (tmp_path / "whole").exists()


def test_the_report_counts_causes_and_ranks() -> None:
    found = CampaignReport([trial(seed, 3 * (seed % 4 == 3)) for seed in range(40)])
    assert (found.successes, found.outcomes["Fail: it stands # m ahead"]) == (30, 10)
    ((blame, times),) = found.blames
    assert (*blame, times) == ("MOVE_TO", "Fail", "watch", "it stands # m ahead", "blocked", 10)
    assert [trial_.seed for trial_ in found.worst()] == [3, 7, 11, 15, 19, 23, 27, 31, 35, 39]
    far, read = found.spreads()["far_mm"], found.spreads()["read"]
    assert (far.low, far.high) == pytest.approx((1.3, 2.6))  # the 14th and the 27th of 40, by the binomial
    assert read.mean == 0.5
    assert read.low == pytest.approx(0.352, abs=1e-3)
    assert found.median_run is not None
    assert found.median_run.seed == 18


@pytest.mark.parametrize("name", ["trials.jsonl", "campaign.json"])
def test_a_pipe_in_the_place_of_a_file_is_refused_at_once(tmp_path: Path, name: str) -> None:
    folder = CampaignFolder.made(tmp_path / "campaign", {"trials": 3})
    (folder.folder / name).unlink(missing_ok=True)
    os.mkfifo(folder.folder / name)
    said: list[Exception] = []
    watched = threading.Thread(target=_open_all, args=(folder, said), daemon=True)
    watched.start()
    watched.join(10.0)
    assert not watched.is_alive(), "it waits for somebody to write"
    assert said
    assert all("a pipe" in str(exception) for exception in said)


def _open_all(folder: CampaignFolder, said: list[Exception]) -> None:
    for attempt in (folder.log, folder.trials, lambda: CampaignFolder.read(folder.folder)):
        try:
            attempt()
        except (TrialLogError, NoCampaign) as error:
            said.append(error)
