"""Runs that are only imagined, and runs that ask or never ask."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said


@pytest.fixture
def script(tmp_path: Path) -> Callable[..., Path]:
    def write(*outcomes: str) -> Path:
        path = tmp_path / "script.yaml"
        path.write_text(f"format: handcart-script/1\noutcomes: [{', '.join(outcomes)}]\n")
        return path

    return write


def test_a_dry_run_plans_and_moves_nothing(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> None:
    said = handcart("run", tour, "--dry-run", "--runs", tmp_path / "runs")
    assert said.status == 0
    assert said.out.startswith(
        "1. MOVE_TO (at_home to at_shelf): Success, 30 s\nSuccess in situation at_shelf\n"
    )
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("outcomes", "status", "count"),
    [
        (["Fail", "Success"], 0, 2),
        (["Fail", "Fail", "Fail"], 3, 3),
        (["FailForGood"], 3, 1),
        (["GiveUp"], 4, 1),
        ([], 0, 1),
    ],
)
def test_outcomes_come_from_a_script(
    handcart: Callable[..., Said],
    tour: Path,
    script: Callable[..., Path],
    outcomes: list[str],
    status: int,
    count: int,
) -> None:
    said = handcart("run", tour, "--script", script(*outcomes), "--json")
    assert said.status == status
    assert json.loads(said.out)["actions"] == count


def test_a_wrong_script_is_told_with_its_place(
    handcart: Callable[..., Said], tour: Path, script: Callable[..., Path]
) -> None:
    said = handcart("run", tour, "--script", script("Fail", "Sucess"))
    assert said.status == 2
    assert "script.yaml:2:" in said.err


def test_a_run_may_begin_elsewhere(handcart: Callable[..., Said], tour: Path) -> None:
    said = handcart("run", tour, "--dry-run", "--from", "at_shelf")
    assert said.out.startswith("Success in situation at_shelf")
    said = handcart("run", tour, "--dry-run", "--from", "at_shlf")
    assert said.status == 2
    assert "did you mean 'at_shelf'?" in said.err


@pytest.mark.slow
def test_never_permits_nothing(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> None:
    tour.write_text(tour.read_text().replace("cost_s: 30,", "cost_s: 30, permit: operator,"))
    said = handcart("run", tour, "--permit", "never", "--runs", tmp_path / "runs")
    assert said.status == 3
    assert "permission was refused" in said.out


@pytest.mark.slow
def test_an_action_that_takes_too_long_restores_and_fails(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    """A4"""
    tour.write_text(tour.read_text().replace("cost_s: 30,", "cost_s: 30, time_out_s: 3, attempts: 1,"))
    said = handcart("run", tour, "--runs", tmp_path / "runs")
    assert said.status == 3
    assert "it took longer than 3 s" in said.out
