"""The key `footprint` of a robot's file."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError


def written(folder: Path, keys: str) -> Path:
    """The cart's file with other keys in place of its radius."""
    lines = robot_path("cart").read_text(encoding="utf-8").splitlines()
    kept = [keys if line.startswith("footprint_radius_m") else line for line in lines]
    assert keys in kept
    shutil.copy(robot_path("cart").parent / "cart.urdf", folder)
    path = folder / "robot.yaml"
    path.write_text("\n".join(kept) + "\n", encoding="utf-8")
    return path


def test_rectangle_has_its_corners_and_the_radius_around_them(tmp_path: Path) -> None:
    robot = load_robot(str(written(tmp_path, "footprint: {rectangle_m: [0.8, 0.6]}")))
    assert robot.footprint_radius_m == pytest.approx(0.5)
    assert robot.footprint_shape.inscribed == pytest.approx(0.3)
    assert sorted(map(tuple, robot.footprint_shape.corners.tolist()))[0] == (-0.4, -0.3)


def test_disc_is_the_same_under_both_keys(tmp_path: Path) -> None:
    robot = load_robot(str(written(tmp_path, "footprint: {radius_m: 0.31}")))
    assert robot.footprint_radius_m == 0.31
    assert robot.footprint_shape.is_disc
    assert load_robot("cart").footprint_shape.is_disc


@pytest.mark.parametrize(
    ("keys", "column", "wrong"),
    [
        ("footprint: {corners_m: [[1, 1], [-1, 1]]}", 24, "2 corners"),
        ("footprint: {corners_m: [[1, 1], [-1, -1], [-1, 1], [1, -1]]}", 24, "cross"),
        ("footprint: {corners_m: [[2, 1], [1, 1], [1, -1]]}", 24, "the origin of `base` is outside"),
        ("footprint: {corners_m: [[1, 1], [1, 1], [-1, 1], [0, -1]]}", 24, "corner 2 is the same"),
        ("footprint: {rectangle_m: [0.5, 0.01]}", 26, "a side is 0.01 m; allowed: 0.04 m or more"),
        ("footprint: {rectangle_m: [0.5, 0.4], radius_m: 0.3}", 12, "radius_m and rectangle_m given"),
        ("footprint: {}", 12, "none of them given"),
        ("footprint: {corner_m: [[1, 1]]}", 13, "did you mean 'corners_m'"),
    ],
)
def test_bad_outline_is_named_at_its_place(tmp_path: Path, keys: str, column: int, wrong: str) -> None:
    path = written(tmp_path, keys)
    line = 1 + path.read_text(encoding="utf-8").split("footprint:")[0].count("\n")
    with pytest.raises(FileError) as found:
        load_robot(str(path))
    assert f"{path}:{line}:{column}: " in str(found.value)
    assert wrong in str(found.value)


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [
        ("footprint: {radius_m: 0.3}\nfootprint_radius_m: 0.4", "both given"),
        ("", "no footprint"),
    ],
)
def test_robot_has_one_footprint(tmp_path: Path, keys: str, wrong: str) -> None:
    with pytest.raises(FileError, match=wrong):
        load_robot(str(written(tmp_path, keys)))
