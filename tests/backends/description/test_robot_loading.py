"""Loading of robots from their files, including files written before a key was renamed."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the cart's file with the old key `localiser`."""
    folder = Path(shutil.copytree(robot_path("cart").parent, tmp_path / "cart"))
    text = (folder / "robot.yaml").read_text(encoding="utf-8")
    assert "\nlocalizer: scan" in text
    (folder / "robot.yaml").write_text(text.replace("\nlocalizer:", "\nlocaliser:"), encoding="utf-8")
    return folder / "robot.yaml"


def test_an_old_key_is_read_with_a_warning(file: Path) -> None:
    robot = load_robot(str(file))
    assert robot.localizer == load_robot("cart").localizer
    (warning,) = robot.warnings
    line = 1 + file.read_text(encoding="utf-8").split("localiser")[0].count("\n")
    assert warning.startswith(f"{file}:{line}:1: the key is called 'localizer' now")
    assert load_robot("cart").warnings == ()


def test_what_is_wrong_under_an_old_key_is_told_at_its_place(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace("localiser: scan", "localiser: scam"), encoding="utf-8")
    with pytest.raises(FileError, match="localizer is 'scam'"):
        load_robot(str(file))


def test_both_keys_are_one_too_many(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    file.write_text(f"localizer: scan\n{text}", encoding="utf-8")
    with pytest.raises(FileError, match="unknown key 'localiser'"):
        load_robot(str(file))


@pytest.mark.parametrize("localizer", ["gps_filter", "particle"])
def test_a_filter_of_position_fixes_needs_a_gps(tmp_path: Path, localizer: str) -> None:
    """Without one, its pose would never be known well enough for anything."""
    path = Path(shutil.copytree(robot_path("el_verde").parent, tmp_path / "el_verde")) / "robot.yaml"
    text = re.sub(r"^localizer: \w+", f"localizer: {localizer}", path.read_text(encoding="utf-8"), flags=re.M)
    path.write_text(text, encoding="utf-8")
    assert load_robot(str(path)).localizer == localizer
    path.write_text(re.sub(r"^gps:.*\n(  .*\n)+", "", text, flags=re.M), encoding="utf-8")
    with pytest.raises(FileError, match=rf"robot\.yaml:\d+:\d+: {localizer} corrects .* the section `gps`"):
        load_robot(str(path))
