"""`handcart explain`: why a run went as it did, from its folder alone."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.books.library_files import Libraries
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.trial_run import run_trial
from handcart.evaluation.viewing.explanation.explanation import explain
from handcart.networks.journal.journal import Journal
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.runs.flight_recorder import load_readings
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]
TASK = ROOT / "tasks" / "return_book" / "paper.yaml"
LIBRARIES: dict[str, tuple[dict[str, Any], str]] = {
    "blocked": ({"blocked": "closed"}, "no way around leads to shelf_"),
    "unreadable": ({"tag": "smeared"}, "no tag can be read"),
    "no_gap": ({"gap": False}, "there is no free slot"),
}
"""What a library is like, and words of the reason that a run in it ends with."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The folder of a run in a generated library; the library's own files are gone."""
    made: dict[str, Path] = {}

    def folder(name: str) -> Path:
        if name not in made:
            library, words = LIBRARIES[name]
            worlds = Libraries.model_validate(library)
            setting = CampaignSetting(TASK, None, None, worlds, tmp_path_factory.mktemp(name))
            done = run_trial(setting, 0)
            assert (done.status, done.untrue) == (3, [])
            assert words in done.summary["reason"]
            made[name] = Path(done.summary["run_dir"])
        return made[name]

    return folder


@pytest.mark.slow
def test_a_blocked_way(handcart: Callable[..., Said], runs: Callable[[str], Path]) -> None:
    folder = runs("blocked")
    said = handcart("explain", folder, "--action", 3, "--json")
    assert said.status == 0
    report = json.loads(said.out)
    assert [item["outcome"] for item in report["actions"]] == ["Success", "Success", "Fail", "Fail"]
    (cause,) = report["cause"]
    assert (cause["check"], cause["calls"]) == ("watch", ["MoveTo.watch"])
    measured = cause["measured"]
    assert measured["sensor"] == "RangeSensor"
    assert 0.0 <= measured["value"] < measured["limit"]
    assert all(residual["within"] for residual in report["residuals"])
    assert {residual["name"] for residual in report["residuals"]} >= {"base_mm", "joints_deg", "held"}
    choice = report["choice"]
    assert [option["do"] for option in choice["options"]] == ["MOVE_TO"]
    assert choice["next_best"] is None
    assert choice["after_fail"]["cost_s"] == 136.0
    assert report["relied_on"] == {"book": 1}
    action = report["actions"][2]
    readings = load_readings(Path(report["readings"]))
    motion = readings["time_s"][readings["time_s"] <= action["broken_off_s"] + 1e-6]
    assert motion[-1] == pytest.approx(action["broken_off_s"])
    assert motion[-1] - motion[0] == pytest.approx(9.95)
    with np.load(report["points"]) as points:
        assert len(points["in the way"]) == 1
    assert Path(report["chart"]).read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.slow
def test_a_blocked_way_in_words(handcart: Callable[..., Said], runs: Callable[[str], Path]) -> None:
    said = handcart("explain", runs("blocked"))
    lines = said.out.splitlines()
    assert any(line.startswith(">   4") and "MODIFY" in line for line in lines)
    assert "obstacles (action 3, MOVE_TO)" in said.out
    assert "RangeSensor: points sensed that are not on the map" in said.out
    assert "nothing had moved" in said.out
    assert "RangeSensor: free way ahead" in handcart("explain", runs("blocked"), "--action", 3).out


@pytest.mark.slow
def test_an_unreadable_tag(
    handcart: Callable[..., Said], runs: Callable[[str], Path], tmp_path: Path
) -> None:
    folder, picture = runs("unreadable"), tmp_path / "chart.png"
    said = handcart("explain", folder, "--picture", picture)
    assert said.status == 0
    assert "RECOGNIZE counted 32 s of it, failed 2 times before" in said.out
    assert "Camera: of 8 pictures those in which a tag was read 0, needed: at least 1" in said.out
    assert "003_RECOGNIZE_Fail_tray.png" in said.out
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_missing_gap(handcart: Callable[..., Said], runs: Callable[[str], Path]) -> None:
    said = handcart("explain", runs("no_gap"), "--json")
    report = json.loads(said.out)
    assert report["actions"][report["action"] - 1]["do"] == "SEARCH"
    assert report["cause"][0]["calls"] == ["Search.motion", "Search._conclude"]
    assert report["cause"][0]["measured"]["sensor"] == "Camera"
    # The view on the place between the neighbours, which isn't the first one that was taken.
    assert Path(report["picture"]).name.startswith("004_SEARCH_Fail_view_")
    assert not report["picture"].endswith("_view_1.png")


@pytest.mark.slow
def test_a_run_that_succeeded(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> None:
    assert handcart("run", tour, "--runs", tmp_path / "runs").status == 0
    folder = tmp_path / "runs" / "tour-0"
    said = handcart("explain", folder)
    assert said.status == 0
    assert "Success in situation at_shelf" in said.out
    assert "Why" not in said.out
    assert (folder / "explained.svg").is_file()
    alone = handcart("explain", folder, "--action", 1)
    assert "cheapest way to the goal, 30 s: MOVE_TO" in alone.out
    assert "dock_mm" in alone.out


@pytest.mark.slow
def test_a_torn_journal_is_told_as_far_as_it_goes(
    handcart: Callable[..., Said], runs: Callable[[str], Path], tmp_path: Path
) -> None:
    folder = tmp_path / "torn"
    shutil.copytree(runs("blocked"), folder)
    journal = folder / "journal.jsonl"
    whole = journal.read_bytes()
    torn_at = whole[:-1].rindex(b"\n") + 1
    journal.write_bytes(whole[:-10])
    said = handcart("explain", folder)
    assert said.status == 0
    assert f"torn at byte {torn_at}" in said.err
    assert "no end in the journal" in said.out
    assert "MODIFY" in said.out


@pytest.mark.slow
def test_a_damaged_journal_is_refused_with_its_place(
    handcart: Callable[..., Said], runs: Callable[[str], Path], tmp_path: Path
) -> None:
    folder = tmp_path / "damaged"
    shutil.copytree(runs("blocked"), folder)
    journal = folder / "journal.jsonl"
    lines = journal.read_bytes().splitlines(keepends=True)
    number = next(n for n, line in enumerate(lines) if b'"kind":"RESULT"' in line)
    lines[number] = lines[number].replace(b"RESULT", b"RESULS")
    journal.write_bytes(b"".join(lines))
    said = handcart("explain", folder)
    assert said.status == 5
    assert f"record {number} at byte {sum(map(len, lines[:number]))} isn't what was written" in said.err


def test_damaged_evidence_is_named(
    handcart: Callable[..., Said], runs: Callable[[str], Path], tmp_path: Path
) -> None:
    folder = tmp_path / "damaged"
    shutil.copytree(runs("blocked"), folder)
    readings = folder / "evidence" / "004_MODIFY_Fail_readings.npz"
    readings.write_bytes(readings.read_bytes()[:1000])
    said = handcart("explain", folder)
    assert said.status == 5
    assert f"{readings} can't be read" in said.err
    assert "Why it ended in Fail" in said.out


def test_folders_that_hold_no_run(handcart: Callable[..., Said], tmp_path: Path) -> None:
    missing = handcart("explain", tmp_path / "nowhere")
    assert (missing.status, "there is no such folder" in missing.err) == (2, True)
    empty = handcart("explain", tmp_path)
    assert (empty.status, "there is no journal.jsonl in it" in empty.err) == (2, True)
    (tmp_path / "journal.jsonl").write_bytes(b"")
    nothing = handcart("explain", tmp_path)
    assert (nothing.status, "holds no whole record" in nothing.err) == (2, True)
    (tmp_path / "journal.jsonl").unlink()
    with Journal(tmp_path / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {"schema": "another/7"})
    foreign = handcart("explain", tmp_path)
    assert (foreign.status, "but of 'another/7'" in foreign.err) == (2, True)


def test_an_action_that_is_not_there(handcart: Callable[..., Said], runs: Callable[[str], Path]) -> None:
    said = handcart("explain", runs("blocked"), "--action", 9)
    assert said.status == 2
    assert "has no action 9; allowed: 1 to 4" in said.err


@pytest.mark.slow
def test_a_picture_that_can_not_be_written(
    handcart: Callable[..., Said], runs: Callable[[str], Path], tmp_path: Path
) -> None:
    said = handcart("explain", runs("blocked"), "--picture", tmp_path / "no" / "chart.svg")
    assert said.status == 2
    assert "can't be written" in said.err
    assert handcart("explain", runs("blocked"), "--picture", tmp_path / "chart.doc").status == 2


@pytest.mark.slow
def test_no_simulator_is_imported(runs: Callable[[str], Path]) -> None:
    code = (
        "import sys\nfrom handcart.tools.main import main\n"
        f"try:\n    main(['explain', {str(runs('blocked'))!r}])\n"
        "except SystemExit as end:\n    assert not end.code\n"
        "rooms = ('kinematic', 'pybullet', 'can', 'scene')\n"
        "bad = {'pybullet', *(f'handcart.backends.{each}' for each in rooms)}\n"
        "print(sorted(bad & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert said.stdout.splitlines()[-1] == "[]"
    assert "Why it ended in Fail" in said.stdout


def forged(folder: Path, header: dict[str, Any], do: str = "MOVE_TO") -> Path:
    """A run's folder with a journal that is whole, and that no run wrote."""
    folder.mkdir()
    with Journal(folder / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {"schema": "handcart-journal/2", **header})
        action = {"index": 0, "do": do, "from": "a", "to": "b", "with": {}}
        journal.append("START", 0.0, {"n": 1, "action": action})
        fields = {"outcome": "Fail", "reason": "it failed", "permanent": False, "residuals": {}}
        journal.append("RESULT", 1.0, {"n": 1, **fields})
    return folder


def test_a_journal_that_somebody_chained_anew_is_told_in_words(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    """D15: its header lacks fields that every run has."""
    said = handcart("explain", forged(tmp_path / "run", {}))
    assert said.status == 5
    assert "makes no sense: KeyError" in said.err
    assert "Traceback" not in said.err


@pytest.mark.parametrize(("index", "source"), [(0, "nowhere"), (1, "a")])
def test_an_action_that_its_network_does_not_have_is_told_in_words(
    handcart: Callable[..., Said], tmp_path: Path, index: int, source: str
) -> None:
    """D15: a forged record with a valid checksum."""
    keys = ("do", "from", "to", "on_fail", "cost_s", "attempts", "uses", "permit", "time_out_s", "with")
    network: dict[str, Any] = {
        "start": "a",
        "goal": "b",
        "situations": {"a": {}, "b": {}},
        "keys": keys,
        "elements": {},
    }
    network["actions"] = [("MOVE_TO", "a", "b", None, 1.0, 3, [], False, None, {})]
    folder = tmp_path / "run"
    folder.mkdir()
    with Journal(folder / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {"schema": "handcart-journal/2", "plan_on": network})
        action = {"index": index, "do": "MOVE_TO", "from": source, "to": "b", "with": {}}
        journal.append("START", 0.0, {"n": 1, "action": action})
    said = handcart("explain", folder)
    assert said.status == 5
    assert f"no such action {index}: MOVE_TO from {source} to b" in said.err
    assert "Traceback" not in said.err


def test_evidence_is_looked_for_in_the_runs_folder_alone(tmp_path: Path) -> None:
    """D15: whatever an action is called."""
    (tmp_path / "001_secret_Fail_readings.npz").write_bytes(b"not for this")
    folder = forged(tmp_path / "run", {"task": "t", "backend": "b", "seed": 0}, "/../../../001_secret")
    (folder / "evidence" / "001_").mkdir(parents=True)
    assert (folder / "evidence" / "001_/../../../001_secret_Fail_readings.npz").is_file()
    explanation = explain(read_run(folder))
    assert (explanation.readings, explanation.points, explanation.picture) == (None, None, None)
