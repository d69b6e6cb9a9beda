"""A campaign as Parquet: all of it, read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial, died
from handcart.evaluation.viewing.export.campaign_parquet import write_parquet


def trial(seed: int, metrics: dict[str, Any], **more: Any) -> Trial:
    ends = [ActionEnd("MOVE_TO (here to there)", "here", "there", "Fail", 1.5, "a wall", "watch")] * seed
    summary = {"outcome": "Success", "reason": "", "sim_time_s": 2.0, "actions": seed, "fails": seed}
    return Trial(seed, 0, {**summary, "run_dir": f"/x/tour-{seed}", "metrics": metrics}, ends, **more)


def read(path: Path) -> list[dict[str, Any]]:
    from arro3.core import Table
    from arro3.io import read_parquet

    table = Table.from_arrow(read_parquet(path))
    columns = {name: table[name].to_pylist() for name in table.column_names}
    return [{name: values[at] for name, values in columns.items()} for at in range(table.num_rows)]


def test_each_trial_is_a_row_with_all_that_is_known_of_it(tmp_path: Path) -> None:
    faults = [{"fault": "slip for 20 periods", "at_s": 12.5, "bitten": 3}]
    trials = [
        trial(0, {"far_mm": 1, "right": True, "label": "A 1", "blocks": [{"x": 1.0}], "untrue": []}),
        trial(1, {"far_mm": 2.5, "right": None, "untrue": ["not so", "nor so"]}, varied={"wheel": 0.1}),
        trial(2, {}, faults=faults),
    ]
    write_parquet(trials, tmp_path / "trials.parquet")
    rows = read(tmp_path / "trials.parquet")
    assert [(row["seed"], row["run"], row["success"]) for row in rows] == [
        (seed, f"tour-{seed}", True) for seed in range(3)
    ]
    assert [row["metrics.far_mm"] for row in rows] == [1.0, 2.5, None]
    assert [row["metrics.right"] for row in rows] == [True, None, None]
    assert [row["metrics.label"] for row in rows] == ["A 1", None, None]
    assert [row["metrics.blocks"] for row in rows] == ['[{"x":1.0}]', None, None]
    assert [row["varied.wheel"] for row in rows] == [None, 0.1, None]
    assert [row["untrue"] for row in rows] == ["", "not so; nor so", ""]
    assert [len(row["action_ends"]) for row in rows] == [0, 1, 2]
    assert rows[2]["action_ends"][1] == trials[2].actions[1]._asdict()
    assert [row["injected"] for row in rows] == [[], [], faults]


def test_a_trial_whose_process_died_has_no_numbers(tmp_path: Path) -> None:
    write_parquet([trial(3, {}), died(4, "its process died 5 times")], tmp_path / "trials.parquet")
    alive, dead = read(tmp_path / "trials.parquet")
    assert (alive["sim_time_s"], alive["actions"], alive["fails"]) == (2.0, 3, 3)
    assert (dead["sim_time_s"], dead["actions"], dead["fails"]) == (None, None, None)
    assert (dead["seed"], dead["outcome"], dead["reason"]) == (4, "Error", "its process died 5 times")


def test_a_metric_of_several_kinds_is_json(tmp_path: Path) -> None:
    write_parquet([trial(0, {"odd": 1}), trial(1, {"odd": "none"})], tmp_path / "trials.parquet")
    assert [item["metrics.odd"] for item in read(tmp_path / "trials.parquet")] == ["1", '"none"']


def test_many_are_written_in_parts_and_none_is_a_file_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("handcart.evaluation.viewing.export.campaign_parquet.BATCH_TRIALS", 7)
    write_parquet([trial(seed, {"far_mm": float(seed)}) for seed in range(20)], tmp_path / "trials.parquet")
    assert [item["seed"] for item in read(tmp_path / "trials.parquet")] == list(range(20))
    write_parquet([], tmp_path / "none.parquet")
    assert read(tmp_path / "none.parquet") == []
