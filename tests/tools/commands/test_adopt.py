"""Taking what a calibration found into a robot's file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

ROBOT = Path(__file__).resolve().parents[3] / "backends" / "robots" / "toyama"
FOUND = """\
format: handcart-calibration/1
robot: {robot}
backend: kinematic
found:
  camera.calibrated.focal_px: {{value: 801.25, sigma: 0.3}}
  camera.calibrated.cx_px: {{value: 320.1, sigma: 0.2}}
  camera.calibrated.cy_px: {{value: 239.9, sigma: 0.2}}
  camera.calibrated.xyz_mm: {{value: [0.5, -1.0, 2.0], sigma: [0.1, 0.1, 0.2]}}
  suspension.pivot_m: {{value: 0.17, sigma: 0.02}}
"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A robot's file of our own."""
    folder = tmp_path / "mine"
    folder.mkdir()
    for name in ("robot.yaml", "toyama.urdf"):
        (folder / name).write_bytes((ROBOT / name).read_bytes())
    return folder / "robot.yaml"


@pytest.fixture
def run(tmp_path: Path, robot: Path) -> Path:
    """A run's folder with findings about that robot."""
    folder = tmp_path / "calibrate_camera-0"
    folder.mkdir()
    (folder / "calibration.yaml").write_text(FOUND.format(robot=robot), encoding="utf-8")
    return folder


def test_the_change_is_shown_for_review(handcart: Callable[..., Said], run: Path, robot: Path) -> None:
    before = robot.read_bytes()
    said = handcart("adopt", run)
    assert said.status == 0
    assert "+    focal_px: 801.25" in said.out
    assert "-  pivot_m: 0.1333\n+  pivot_m: 0.17" in said.out
    assert "camera.calibrated.xyz_mm    0.1, 0.1, 0.2" in said.out
    assert "nothing is changed yet; --write" in said.out
    assert robot.read_bytes() == before


def test_it_is_written_and_nothing_else_changes(
    handcart: Callable[..., Said], run: Path, robot: Path
) -> None:
    from handcart.backends.loading.robot_loading import load_robot

    before = robot.read_text(encoding="utf-8")
    assert handcart("adopt", run, "--write").status == 0
    after = robot.read_text(encoding="utf-8")
    expected = before.replace("pivot_m: 0.1333\n", "pivot_m: 0.17\n", 1).replace(
        "  k2: 0.09\n",
        "  k2: 0.09\n  calibrated:\n    focal_px: 801.25\n    cx_px: 320.1\n    cy_px: 239.9\n"
        "    xyz_mm: [0.5, -1.0, 2.0]\n",
    )
    assert after == expected
    spec = load_robot(str(robot))
    assert spec.camera is not None
    assert spec.camera.calibrated is not None
    assert spec.camera.calibrated.xyz_mm == (0.5, -1.0, 2.0)
    assert spec.suspension.pivot_m == 0.17
    assert "has these values already" in handcart("adopt", run, "--write").out


def test_a_read_only_file_is_copied_where_asked(
    handcart: Callable[..., Said], run: Path, robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from handcart.backends.loading.robot_loading import load_robot

    allowed = os.access
    with monkeypatch.context() as patch:
        patch.setattr(os, "access", lambda path, mode: mode != os.W_OK and allowed(path, mode))
        said = handcart("adopt", run, "--write")
    assert said.status == 2
    assert f"{robot} can't be written: it is read-only; allowed: -o FILE" in said.err
    copy = tmp_path / "elsewhere" / "copy.yaml"
    assert handcart("adopt", run, "-o", copy).status == 0
    assert load_robot(str(copy)).suspension.pivot_m == 0.17
    assert load_robot(str(robot)).suspension.pivot_m == 0.1333


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--robot", "toyamo"), "unknown robot; did you mean 'toyama'"),
        (("--robot", "cart"), "calibrated:"),  # has no camera
        (("-o", "robot.txt"), "allowed: *.yaml"),
    ],
)
def test_what_cannot_be_adopted_is_refused(
    handcart: Callable[..., Said], run: Path, words: tuple[str, ...], message: str
) -> None:
    said = handcart("adopt", run, *words)
    assert said.status == 2
    assert message in said.err


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("sigma: 0.02", "sigma: -0.02", "calibration.yaml:9:"),
        (
            "suspension.pivot_m: {value: 0.17",
            "suspension.pivot: {value: 0.17",
            "robot.yaml, calibrated:61:3: unknown key 'pivot'",
        ),
        ("value: 0.17", "value: -1.0", "pivot_m"),
        ("sigma: [0.1, 0.1, 0.2]", "sigma: 0.1", "value and sigma aren't alike"),
    ],
)
def test_findings_that_cannot_be_are_told_with_their_place(
    handcart: Callable[..., Said], run: Path, before: str, after: str, message: str
) -> None:
    file = run / "calibration.yaml"
    text = file.read_text(encoding="utf-8")
    assert before in text
    file.write_text(text.replace(before, after), encoding="utf-8")
    said = handcart("adopt", run)
    assert said.status == 2
    assert message in said.err


def test_a_run_without_findings(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("adopt", tmp_path)
    assert said.status == 2
    assert "has no calibration.yaml; allowed: the folder of a run" in said.err
