from __future__ import annotations

from pathlib import Path

import orjson
import pytest

from handcart.networks.run_files.run_folder import NoRun
from handcart.networks.run_files.run_names import latest_run, list_runs, name_of, point_latest


def a_run(runs: Path, name: str, begun: float, outcome: str | None) -> Path:
    folder = runs / name
    folder.mkdir(parents=True)
    header = {"task_path": "tour.yaml", "seed": 3, "backend": "kinematic", "wall": {"unix_s": begun}}
    (folder / "journal.jsonl").write_bytes(orjson.dumps(header) + b"\n")
    if outcome is not None:
        (folder / "summary.json").write_bytes(orjson.dumps({"outcome": outcome}))
    return folder


def test_a_folder_is_called_after_the_tasks_file(tmp_path: Path) -> None:
    assert name_of(tmp_path / "shelf" / "night.yaml", 4) == "night-4"
    assert name_of(tmp_path / "shelf" / "task.yaml", 0) == "shelf-0"


def test_latest_leads_to_the_run_begun_last(tmp_path: Path) -> None:
    for name in ("a-0", "b-0"):
        point_latest(a_run(tmp_path, name, 1.0, None))
    assert latest_run(tmp_path) == tmp_path / "b-0"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a-0", "b-0", "latest"]


def test_a_folder_called_latest_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "latest").mkdir()
    point_latest(a_run(tmp_path, "a-0", 1.0, None))
    assert not (tmp_path / "latest").is_symlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a-0", "latest"]
    with pytest.raises(NoRun, match="no run is known"):
        latest_run(tmp_path)


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "latest").symlink_to("../elsewhere")
    with pytest.raises(NoRun, match="leads out"):
        latest_run(tmp_path)


def test_the_newest_run_is_listed_first_and_none_twice(tmp_path: Path) -> None:
    a_run(tmp_path, "a-0", 1.0, "Success")
    point_latest(a_run(tmp_path, "b-0", 2.0, None))
    (tmp_path / "notes").mkdir()
    (tmp_path / "torn-0").mkdir()
    (tmp_path / "torn-0" / "journal.jsonl").write_text('{"q":')
    assert [(run.folder.name, run.outcome) for run in list_runs(tmp_path)] == [
        ("b-0", ""),
        ("a-0", "Success"),
    ]
