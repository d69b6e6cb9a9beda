"""Files that a campaign depends on."""

from pathlib import Path

import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.campaign_files import checksums
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.networks.task.task_file import load_task


def sums(task: Path, settings: dict[str, str] | None = None) -> dict[str, str]:
    """Return the checksums of a campaign that walks through the task's network."""
    setting = CampaignSetting(task, settings=settings or {}, level="network")
    return checksums(setting, load_task(task, setting.settings))


def test_files_of_the_same_name_in_the_current_folder_do_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = walk(tmp_path)
    before = sums(task)
    assert {"walk.yaml", "map.yaml", "map.png", "places.yaml"} <= before.keys()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    for name in ("map.yaml", "map.png", "places.yaml"):
        (elsewhere / name).write_text("another: content.yaml\n", encoding="utf-8")
    monkeypatch.chdir(elsewhere)
    assert sums(task) == before


def test_two_files_of_one_name_both_count(tmp_path: Path) -> None:
    task, more = walk(tmp_path), tmp_path / "more"
    more.mkdir()
    (more / "map.png").write_bytes(b"one")
    text = task.read_text(encoding="utf-8")
    task.write_text(text.replace("title:", "title: more/map.png #", 1), encoding="utf-8")
    before = sums(task)
    assert {"map.png", "more/map.png"} <= before.keys()
    (more / "map.png").write_bytes(b"another")
    after = sums(task)
    assert [name for name in after if after[name] != before[name]] == ["more/map.png"]


@pytest.mark.parametrize("title", [r'"a.\0b"', "a. " + 300 * "b", ".", "../.."])
def test_a_text_that_can_be_no_file_is_none(tmp_path: Path, title: str) -> None:
    task = walk(tmp_path)
    before = sums(task)
    text = task.read_text(encoding="utf-8")
    task.write_text(text.replace("title: Drive to a shelf", f"title: {title}", 1), encoding="utf-8")
    after = sums(task)
    assert after.keys() == before.keys()
    assert [name for name in after if after[name] != before[name]] == ["walk.yaml"]


def test_where_the_task_lies_does_not_matter(tmp_path: Path) -> None:
    places = [tmp_path / name for name in ("here", "there")]
    for place in places:
        place.mkdir()
    here, there = (sums(walk(place)) for place in places)
    assert here == there


def test_a_file_that_was_set_is_looked_for_from_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = Path(__file__).parents[3] / "tasks" / "drive_map" / "task.yaml"
    mine = tmp_path / "places.yaml"
    mine.write_bytes((task.parent / "places.yaml").read_bytes())
    monkeypatch.chdir(tmp_path)
    before = sums(task, {"places": "places.yaml"})
    assert "--set places.yaml" in before
    mine.write_bytes(mine.read_bytes() + b"# changed\n")
    after = sums(task, {"places": "places.yaml"})
    assert [name for name in after if after[name] != before[name]] == ["--set places.yaml"]
