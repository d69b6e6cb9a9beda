"""`handcart check` on robots, `teach --hand`, and robots chosen on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

ROBOTS = Path(__file__).resolve().parents[3] / "backends" / "robots"


@pytest.mark.slow
def test_a_robot_is_told_in_tables(handcart: Callable[..., Said]) -> None:
    said = handcart("check", ROBOTS / "librarian" / "robot.yaml")
    assert said.status == 0
    assert "no fault found" in said.out
    for words in (
        "joint_3   revolute   6 deg      169 deg   86 deg/s   60 Nm",
        "heaviest: base 38 kg",
        "2.7 px a mm at 0.3 m",
    ):
        assert words in said.out
    assert max(len(line) for line in said.out.splitlines()) <= 120


@pytest.mark.slow
def test_programs_get_the_same(handcart: Callable[..., Said]) -> None:
    report = json.loads(handcart("check", ROBOTS / "librarian" / "robot.yaml", "--json").out)
    assert report["ok"]
    assert report["robot"]["joints"][4]["name"] == "joint_3"
    assert {row["board_m"] for row in report["robot"]["books"]["grasps"]} >= {0.62, 0.7}
    assert report["robot"]["links"][0] == {"name": "base", "mass_kg": 38.0, "faults": []}


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["svg", "png"])
def test_a_picture_is_drawn(handcart: Callable[..., Said], tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"robot.{ending}"
    assert handcart("check", ROBOTS / "cart" / "robot.yaml", "--picture", path).status == 0
    drawn = path.read_bytes()
    assert drawn.startswith(b"<?xml" if ending == "svg" else b"\x89PNG")
    assert handcart("check", ROBOTS / "cart" / "robot.yaml", "--picture", path).status == 0
    assert path.read_bytes() == drawn


@pytest.mark.parametrize(
    ("picture", "words"), [("robot.bmp", "allowed: .svg, .png, .pdf"), ("none/robot.svg", "can't be written")]
)
def test_a_picture_that_cannot_be_drawn_is_bad_input(
    handcart: Callable[..., Said], tmp_path: Path, picture: str, words: str
) -> None:
    said = handcart("check", ROBOTS / "cart" / "robot.yaml", "--picture", tmp_path / picture)
    assert said.status == 2
    assert words in said.err


@pytest.mark.slow
def test_another_robot_runs_a_task_that_names_one(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    said = handcart("run", tour, "--robot", "cart", "--runs", tmp_path / "runs", "--json")
    assert said.status == 0
    journal = next((tmp_path / "runs").glob("*/journal.jsonl")).read_text(encoding="utf-8")
    assert '"settings":{"robot":"cart"}' in journal


@pytest.mark.parametrize("command", ["run", "campaign"])
def test_an_unknown_robot_is_told_with_the_nearest_name(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, command: str
) -> None:
    jobs = ("--jobs", "1") if command == "campaign" else ()
    said = handcart(command, tour, "--robot", "libarian", "--runs", tmp_path / "runs", *jobs)
    assert said.status == 2
    assert "unknown robot 'libarian'; did you mean 'librarian'?" in said.err


def test_a_posture_is_taught_by_where_the_hand_is_to_be(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    for name in ("robot.yaml", "librarian.urdf"):
        (tmp_path / name).write_bytes((ROBOTS / "librarian" / name).read_bytes())
    said = handcart("teach", "wave", "--robot", tmp_path / "robot.yaml", "--hand=0.1,-0.05,0.8")
    assert said.status == 0
    assert "+    wave: [" in said.out
    far = handcart("teach", "wave", "--robot", tmp_path / "robot.yaml", "--hand=3,0,0.8")
    assert far.status == 2
    assert "no posture has the hand at 3,0,0.8 m" in far.err
