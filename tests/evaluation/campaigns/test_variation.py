"""Numbers that vary from trial to trial."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.variation import Variation, load_variation
from handcart.files.errors import FileError
from handcart.files.yaml.yaml_document import changed_numbers
from handcart.networks.task.task_file import load_task
from tests.tools.conftest import TOUR, Said
from tests.tools.conftest import handcart as handcart

HEAD = "format: handcart-vary/1\n"


def variation(tmp_path: Path, text: str) -> Variation:
    path = tmp_path / "vary.yaml"
    path.write_text(HEAD + text, encoding="utf-8")
    return load_variation(path, load_task(walk(tmp_path)))


def test_a_grid_is_gone_through(tmp_path: Path) -> None:
    found = variation(
        tmp_path,
        "design: grid\nvary:\n  - {file: task, key: actions.0.p, list: [0.5, 0.9]}\n"
        "  - {file: task, key: actions.1.cost_s, grid: {least: 1, most: 2, count: 3}}\n",
    )
    rows = [tuple(found.row(seed, range(9)).values()) for seed in range(7)]
    assert rows == [(0.5, 1), (0.5, 1.5), (0.5, 2), (0.9, 1), (0.9, 1.5), (0.9, 2), (0.5, 1)]


@pytest.mark.parametrize("design", ["random", "latin_hypercube"])
def test_distributions(tmp_path: Path, design: str) -> None:
    found = variation(
        tmp_path,
        f"design: {design}\nvary:\n  - {{file: task, key: actions.0.cost_s, uniform: [10, 20]}}\n"
        "  - {file: task, key: actions.1.cost_s, normal: [50, 2]}\n"
        "  - {file: task, key: actions.2.cost_s, log_uniform: [1, 100]}\n",
    )
    seeds = range(5, 405)
    rows = np.array([list(found.row(seed, seeds).values()) for seed in seeds])
    assert rows.mean(axis=0)[:2] == pytest.approx([15.0, 50.0], abs=0.6)
    assert np.median(rows[:, 2]) == pytest.approx(10.0, rel=0.4)
    each = np.unique(np.floor((rows[:, 0] - 10) * 40))
    assert (len(each) == 400) == (design == "latin_hypercube")
    assert list(found.row(77, seeds).values()) == rows[72].tolist()


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("{file: task, key: actions.0.q, list: [1]}", "has no number actions.0.q"),
        ("{file: task, key: actions.0.cots_s, list: [1]}", "did you mean 'cost_s'?"),
        ("{file: task, key: title, list: [1]}", "title is no number"),
        ("{file: robot, key: drive.tread, list: [1]}", "did you mean 'tread_m'?"),
        ("{file: task, key: actions.0.p}", "needed: one of list, grid, uniform"),
        ("{file: task, key: actions.0.p, uniform: [2, 1]}", "the least isn't below the most"),
    ],
)
def test_what_cannot_vary_is_refused(tmp_path: Path, line: str, wrong: str) -> None:
    with pytest.raises(FileError) as refused:
        variation(tmp_path, f"vary:\n  - {line}\n")
    assert wrong in str(refused.value)
    assert "vary.yaml:3:" in str(refused.value)


def test_a_latin_hypercube_with_a_negative_first_seed_is_refused(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    lines = "design: latin_hypercube\nvary:\n  - {file: task, key: actions.2.cost_s, uniform: [100, 200]}\n"
    variation(tmp_path, lines)
    words = ("campaign", walk(tmp_path), "--level", "network", "--trials", "2", "--jobs", "1")
    said = handcart(*words, "--vary", tmp_path / "vary.yaml", "--first", "-3")
    assert said.status == 2
    assert "--first -3 with the design latin_hypercube of --vary; allowed: 0 and more" in said.err


def test_numbers_stand_in_the_files_while_the_context_lasts(tmp_path: Path) -> None:
    task = walk(tmp_path)
    with changed_numbers({task: {("actions", 0, "cost_s"): 77.0}}):
        assert load_task(task).file.actions[0].cost_s == 77.0
    assert load_task(task).file.actions[0].cost_s == 20.0


@pytest.mark.slow
def test_a_campaign_keeps_what_varied_with_each_trial(handcart: Callable[..., Said], tmp_path: Path) -> None:
    variation(tmp_path, "vary:\n  - {file: task, key: actions.2.cost_s, uniform: [100, 200]}\n")
    command = ["campaign", walk(tmp_path), "--level", "network", "--trials", 12]
    command += ["--vary", tmp_path / "vary.yaml"]
    said = handcart(*command, "--out", tmp_path / "whole")
    assert said.status == 0, said.err
    whole = CampaignFolder.read(tmp_path / "whole").trials()
    arrived = [trial for trial in whole if trial.success]
    assert len(arrived) > 6
    for trial in arrived:
        cost, last = trial.varied["task actions.2.cost_s"], trial.actions[-1]
        before = trial.actions[-2].time_s
        assert 100.0 <= cost < 200.0
        assert last.time_s - before == pytest.approx(cost)
    again = handcart(*command, "--shard", "3/12", "--out", tmp_path / "part")
    (trial,) = CampaignFolder.read(tmp_path / "part").trials()
    assert (again.status, trial) == (0, whole[2])


@pytest.mark.slow
def test_a_number_of_the_world_varies_and_the_robot_finds_it_so(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    """A desk stands where its map has it, then across the way: it drives round it."""
    walk(tmp_path)
    (tmp_path / "tour.yaml").write_text(TOUR, encoding="utf-8")
    line = "{file: world, key: furniture.0.x_m, list: [3.0, 4.4]}"
    (tmp_path / "vary.yaml").write_text(f"{HEAD}design: grid\nvary:\n  - {line}\n", encoding="utf-8")
    words = ("--trials", "2", "--jobs", "1", "--vary", tmp_path / "vary.yaml", "--out", tmp_path / "out")
    assert handcart("campaign", tmp_path / "tour.yaml", *words).status == 0
    as_drawn, across = CampaignFolder.read(tmp_path / "out").trials()
    assert [list(item.varied.values()) for item in (as_drawn, across)] == [[3.0], [4.4]]
    driven = [item.summary["metrics"]["path_length_m"] for item in (as_drawn, across)]
    assert driven[1] > driven[0] + 1.0
    assert across.success
