"""Recording postures into a robot's file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

ROBOT = Path(__file__).resolve().parents[3] / "backends" / "robots" / "librarian"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A robot's file of our own."""
    for name in ("robot.yaml", "librarian.urdf"):
        (tmp_path / name).write_bytes((ROBOT / name).read_bytes())
    return tmp_path / "robot.yaml"


def test_a_posture_is_recorded_and_nothing_else_changes(handcart: Callable[..., Said], robot: Path) -> None:
    before = robot.read_text(encoding="utf-8").splitlines()
    said = handcart("teach", "wave", "--robot", robot, "--joints", "0,-30,90,0,0,0.1234")
    assert said.status == 0
    assert "+    wave: [0.0, -30.0, 90.0, 0.0, 0.0, 0.123]" in said.out
    after = robot.read_text(encoding="utf-8").splitlines()
    last = max(number for number, line in enumerate(before) if line.startswith("    ") and "[-" in line)
    assert after == [
        *before[: last + 1],
        "    wave: [0.0, -30.0, 90.0, 0.0, 0.0, 0.123]",
        *before[last + 1 :],
    ]


def test_postures_are_copied_and_replaced(handcart: Callable[..., Said], robot: Path) -> None:
    from handcart.backends.description.robot_loading import load_robot

    for source in ("carry", "home"):
        assert handcart("teach", "pick_up_1", "--robot", robot, "--from-posture", source).status == 0
        spec = load_robot(str(robot))
        assert spec.posture("pick_up_1") == spec.posture(source)


def test_a_dry_run_writes_nothing(handcart: Callable[..., Said], robot: Path) -> None:
    before = robot.read_bytes()
    said = handcart("teach", "wave", "--robot", robot, "--from-posture", "home", "--dry-run")
    assert said.status == 0
    assert "+    wave" in said.out
    assert robot.read_bytes() == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("wave", "--joints", "0,0,1000,0,0,0"), "joint_3 can't stand at 1000 deg"),
        (("wave", "--joints", "0,nan,0,0,0,0"), "joint_2 can't stand at nan deg"),
        (("wave", "--joints", "0,0,0"), "allowed: 6"),
        (("wave", "--joints", "a,b"), "are no angles"),
        (("wave", "--from-posture", "cary"), "did you mean 'carry'"),
        (("wave",), "either --joints, --hand or --from-posture"),
        (("wave", "--joints", "0,0,0,0,0,0", "--from-posture", "home"), "--joints, --hand or --from-posture"),
        (("Wave: 1", "--from-posture", "home"), "is no name"),
    ],
)
def test_what_cant_be_recorded_is_refused(
    handcart: Callable[..., Said], robot: Path, words: tuple[str, ...], message: str
) -> None:
    before = robot.read_bytes()
    said = handcart("teach", *words, "--robot", robot)
    assert said.status == 2
    assert message in said.err
    assert robot.read_bytes() == before
