"""Laying sensors outdoors, as its user does."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.offline_localization.logs.csv_log import read_csv_log
from handcart.evaluation.offline_localization.replay import localizer_for, replay
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.files.errors import FileError
from handcart.networks.operator.permits import Permits
from handcart.networks.runs.run_options import RunOptions
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from tests.conftest import Copier

TASKS = Path(__file__).parents[2] / "tasks"
STRAIGHT, ZIGZAG = TASKS / "deploy_straight" / "task.yaml", TASKS / "deploy_zigzag" / "task.yaml"
TWO = "name,x_m,y_m\nfirst,6,-0.75\nsecond,14,-0.75\n"
WORLD = """\
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0}
ground: {}
sensors: {count: 3}
total_station: {x_m: -5.0, y_m: -8.0}
"""
IN_THE_WAY = "surprises: [{name: crate, x_m: 10.0, y_m: 0.2, size_m: [0.6, 0.6, 1.0]}]\n"


def write_small(folder: Path) -> dict[str, str]:
    """Write a field with two targets; return its settings."""
    (folder / "two.csv").write_text(TWO, encoding="utf-8")
    (folder / "small.yaml").write_text(WORLD, encoding="utf-8")
    (folder / "crate.yaml").write_text(WORLD + IN_THE_WAY, encoding="utf-8")
    return {"targets": str(folder / "two.csv"), "world": str(folder / "small.yaml"), "wait_s": "20"}


@pytest.fixture
def small(tmp_path: Path) -> dict[str, str]:
    """Settings for a field with two targets."""
    return write_small(tmp_path)


@pytest.fixture(scope="module")
def laid(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], int]:
    """Summary and status of a run in which two sensors are laid."""
    folder = tmp_path_factory.mktemp("laid")
    return run_task(STRAIGHT, folder, RunOptions(settings=write_small(folder), seed=2, draw=True))


@pytest.mark.slow
def test_two_sensors_are_laid_and_told_of(laid: tuple[dict[str, Any], int]) -> None:
    summary, status = laid
    metrics, folder = summary["metrics"], Path(summary["run_dir"])
    assert status == 0
    assert metrics["untrue"] == []
    assert metrics["placed"] == 2
    assert metrics["out_of_sight"] == 0
    assert metrics["error_mm_max"] < 900.0
    for row in metrics["placements"]:
        assert abs(row["x_mm"] - row["true_x_mm"]) < 40.0  # four sigma of the total station
    with (folder / "as_laid.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["first", "second"]
    drawn = json.loads((folder / "as_laid.geojson").read_text(encoding="utf-8"))
    kinds = [feature["geometry"]["type"] for feature in drawn["features"]]
    assert kinds == ["Point", "Polygon"] * 2
    assert (folder / "as_laid.svg").stat().st_size > 10_000
    log = read_csv_log(folder / "drive.csv")
    assert np.diff(log.times) == pytest.approx(0.025)
    replayed = replay(log, localizer_for(log, REFERENCE_NOISE))
    assert len(replayed.fixes) == pytest.approx(log.times[-1], abs=2)
    assert np.hypot(*replayed.errors[:, :2].T).max() < 1.0


@pytest.mark.slow
def test_the_same_seed_gives_the_same_run_and_killed_it_goes_on(
    tmp_path: Path, small: dict[str, str], copier: type[Copier]
) -> None:
    left = tmp_path / "left"
    plain, _ = run_task(STRAIGHT, tmp_path / "plain", RunOptions(settings=small, seed=5))
    whole, _ = run_task(
        STRAIGHT, tmp_path, RunOptions(settings=small, seed=5, checkpoints=True, observers=(copier(4, left),))
    )
    assert whole["metrics"]["placements"] == plain["metrics"]["placements"]
    again, status = resume_task(left, None, RunOptions(observers=(copier(0, left),)))
    assert status == 0
    assert again["metrics"]["placements"] == whole["metrics"]["placements"]
    for name in ("as_laid.csv", "as_laid.geojson", "drive.csv"):
        assert (left / name).read_bytes() == (Path(whole["run_dir"]) / name).read_bytes()


@pytest.mark.slow
def test_with_a_better_receiver_they_lie_within_centimetres(tmp_path: Path, small: dict[str, str]) -> None:
    metrics = run_task(STRAIGHT, tmp_path, RunOptions(settings={**small, "robot": "el_verde/rtk"}, seed=4))[
        0
    ]["metrics"]
    assert metrics["error_mm_max"] < 80.0


@pytest.mark.slow
def test_around_what_no_map_shows_another_way_is_found(tmp_path: Path, small: dict[str, str]) -> None:
    settings = {**small, "world": str(tmp_path / "crate.yaml")}
    summary, status = run_task(STRAIGHT, tmp_path, RunOptions(settings=settings, seed=3))
    assert status == 0
    assert summary["fails"] >= 1
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["placed"] == 2
    assert b"MODIFY" in (Path(summary["run_dir"]) / "journal.jsonl").read_bytes()


@pytest.mark.slow
def test_together_the_arm_moves_while_the_base_drives(
    tmp_path: Path, small: dict[str, str], laid: tuple[dict[str, Any], int]
) -> None:
    settings, (apart, _) = {**small, "together": "true"}, laid
    summary, status = run_task(STRAIGHT, tmp_path, RunOptions(settings=settings, seed=2))
    assert status == 0
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["placed"] == 2
    assert summary["metrics"]["error_mm_max"] < 900.0
    assert summary["sim_time_s"] < apart["sim_time_s"] - 20.0


@pytest.mark.slow
def test_together_a_drive_that_fails_brings_back_base_and_arm(tmp_path: Path, small: dict[str, str]) -> None:
    settings = {**small, "together": "true", "world": str(tmp_path / "crate.yaml")}
    summary, status = run_task(STRAIGHT, tmp_path, RunOptions(settings=settings, seed=3))
    assert status == 0
    assert summary["fails"] >= 1
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["placed"] == 2


def test_the_operator_may_refuse(tmp_path: Path, small: dict[str, str]) -> None:
    settings = {**small, "permit": "operator"}
    summary, status = run_task(
        STRAIGHT, tmp_path, RunOptions(settings=settings, seed=3, permits=Permits("never"))
    )
    assert status == 3
    assert summary["metrics"]["placed"] == 0


@pytest.mark.slow
def test_without_satellites_the_ellipses_grow(tmp_path: Path, small: dict[str, str]) -> None:
    settings = {**small, "robot": _robot(tmp_path, "gyro"), "sure_mm": "2000"}
    first, second = run_task(STRAIGHT, tmp_path, RunOptions(settings=settings, seed=1))[0]["metrics"][
        "placements"
    ]
    assert second["sigma_y_mm"] > 1.5 * first["sigma_y_mm"]


@pytest.mark.slow
def test_the_particle_filter_does_it_too(tmp_path: Path, small: dict[str, str]) -> None:
    settings = {**small, "robot": _robot(tmp_path, "particle")}
    summary, status = run_task(STRAIGHT, tmp_path, RunOptions(settings=settings, seed=1, draw=True))
    assert status == 0
    assert summary["metrics"]["placed"] == 2
    assert summary["metrics"]["untrue"] == []
    assert "particles, each 10 m" in (Path(summary["run_dir"]) / "as_laid.svg").read_text(encoding="utf-8")


def test_a_target_beside_a_rock_is_refused_by_its_line(tmp_path: Path, small: dict[str, str]) -> None:
    field = (TASKS / "deploy_straight" / "field.yaml").read_text(encoding="utf-8")
    rocks = "rocks: [{x_m: 14.0, y_m: 1.0, radius_m: 0.4}]\n"
    (tmp_path / "field.yaml").write_text(field + rocks, encoding="utf-8")
    with pytest.raises(FileError, match=r"two\.csv:3:1: the target 'second' can't be reached"):
        run_task(STRAIGHT, tmp_path, RunOptions(settings={**small, "field": str(tmp_path / "field.yaml")}))


def test_bad_targets_are_reported_by_line_and_nothing_else(tmp_path: Path, small: dict[str, str]) -> None:
    (tmp_path / "bad.csv").write_text(TWO + "third,nan,1\nfirst,20,-0.75\n", encoding="utf-8")
    with pytest.raises(FileError) as refused:
        run_task(STRAIGHT, tmp_path, RunOptions(settings={**small, "targets": str(tmp_path / "bad.csv")}))
    lines = str(refused.value).splitlines()
    assert [line.partition("bad.csv:")[2][:1] for line in lines] == ["4", "5"]


@pytest.mark.slow
def test_the_zigzag_course(tmp_path: Path) -> None:
    summary, status = run_task(ZIGZAG, tmp_path, RunOptions(seed=3))
    assert status == 0
    assert summary["metrics"]["placed"] == 7
    assert summary["metrics"]["error_mm_max"] < 849.0
    assert summary["metrics"]["nees_mean"] < 6.0


def _robot(tmp_path: Path, localizer: str) -> str:
    """The robot with another way of finding out where it is."""
    folder = Path(__file__).parents[2] / "backends" / "robots" / "el_verde"
    text = (folder / "robot.yaml").read_text(encoding="utf-8")
    (tmp_path / "el_verde.urdf").write_text((folder / "el_verde.urdf").read_text(encoding="utf-8"))
    path = tmp_path / "robot.yaml"
    path.write_text(text.replace("localizer: gps_filter", f"localizer: {localizer}"), encoding="utf-8")
    return str(path)
