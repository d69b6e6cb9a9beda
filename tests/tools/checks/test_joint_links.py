"""Links of wheels and fingers that have other names than their joints."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot


def with_other_links(name: str, folder: Path, joints: str) -> Path:
    """Return the file of a shipped robot whose URDF calls the links of some joints `NAME_link`."""
    shutil.copytree(robot_path(name).parent, folder, dirs_exist_ok=True)
    urdf = folder / f"{name}.urdf"
    text = re.sub(rf'(<link name=|<child link=)"((?:left|right)_{joints})"', r'\1"\2_link"', urdf.read_text())
    assert text != urdf.read_text()
    urdf.write_text(text)
    return folder / "robot.yaml"


@pytest.mark.skipif(find_spec("mujoco") is None, reason="needs MuJoCo")
def test_wheels_are_driven_whatever_their_links_are_called(
    tmp_path: Path, handcart: Callable[..., Any]
) -> None:
    robot = with_other_links("cart", tmp_path, "wheel")
    said = handcart("check", robot, "--backend", "mujoco")
    assert (said.status, "Traceback" in said.err) == (0, False)
    assert "left_wheel" in {name for kind, name in load_robot(str(robot)).whole.places if kind == "link"}


def test_fingers_are_found_whatever_their_links_are_called(tmp_path: Path) -> None:
    own = load_robot("librarian").finger_shape
    assert load_robot(str(with_other_links("librarian", tmp_path, "finger"))).finger_shape == own
