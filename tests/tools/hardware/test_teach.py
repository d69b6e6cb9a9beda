"""Recording postures into a robot's file."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
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
    from handcart.backends.loading.robot_loading import load_robot

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
        (("wave", "--joints", "a,b"), "invalid angles"),
        (("wave", "--from-posture", "cary"), "did you mean 'carry'"),
        (("wave",), "either --joints, --hand or --from-posture"),
        (("wave", "--joints", "0,0,0,0,0,0", "--from-posture", "home"), "--joints, --hand or --from-posture"),
        (("Wave: 1", "--from-posture", "home"), "invalid name"),
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


@pytest.mark.parametrize(
    ("options", "x", "z"),
    [
        (("--hand=0.3,-0.2,0.8",), (1, 0, 0), (0, 0, 1)),
        (("--hand=0.3,-0.2,0.8", "--pointing", "down"), (0, 0, -1), None),
        (("--hand=0.3,-0.2,0.8", "--pointing", "down", "--roll", "90"), (0, 0, -1), (0, -1, 0)),
        (("--hand=0.2,-0.4,0.8", "--pointing", "right"), (0, -1, 0), (0, 0, 1)),
        (("--hand=0.4,-0.2,0.7", "--pointing=1,0,-1"), (0.7071, 0, -0.7071), (0.7071, 0, 0.7071)),
    ],
)  # fmt: skip
def test_hand_points_the_given_way(
    handcart: Callable[..., Said],
    robot: Path,
    options: tuple[str, ...],
    x: tuple[float, ...],
    z: tuple[float, ...] | None,
) -> None:
    from handcart.backends.loading.robot_loading import load_robot

    said = handcart("teach", "look", "--robot", robot, *options)
    assert said.status == 0, said.err
    assert said.err == ""
    spec = load_robot(str(robot))
    pose = spec.arm_model().forward(np.array(spec.posture("look")))
    assert pose[:3, 3] == pytest.approx([float(part) for part in options[0][7:].split(",")], abs=1e-4)
    assert pose[:3, 0] == pytest.approx(x, abs=1e-3)
    assert z is None or pose[:3, 2] == pytest.approx(z, abs=1e-3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--pointing", "down"), "the hand's position is missing; needed: --hand X,Y,Z"),
        (("--hand=0.3,0,0.8", "--pointing", "dwn"), "invalid direction 'dwn'; did you mean 'down'?"),
        (("--hand=0.3,0,0.8", "--pointing=0,0,0"), "invalid direction '0,0,0'; allowed: not all 0"),
        (("--hand=0.3,0,nan",), "invalid place '0.3,0,nan'"),
        (("--hand=3,0,0.8", "--pointing", "down"), "no posture has the hand at 3,0,0.8 m, pointing"),
        (("--hand=-0.12,0.05,0.45", "--pointing", "down"), "is free of the robot itself"),
    ],
)  # fmt: skip
def test_hand_that_cannot_point_there_is_refused(
    handcart: Callable[..., Said], robot: Path, options: tuple[str, ...], words: str
) -> None:
    said = handcart("teach", "look", "--robot", robot, *options)
    assert said.status == 2
    assert words in " ".join(said.err.replace("│", " ").split())


def test_posture_that_touches_itself_is_taught_with_a_warning(
    handcart: Callable[..., Said], robot: Path
) -> None:
    said = handcart("teach", "folded", "--robot", robot, "--joints", "0,-90,150,0,100,0")
    assert said.status == 0
    assert re.search(r"warning: \w+ touches \w+ in this posture", said.err)
