"""The table of robots, backends and primitives."""

from __future__ import annotations

from pathlib import Path
from unittest.mock import patch

import pytest

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.urdf import robot_parts
from handcart.tools.checks.robot_table import robot_table
from handcart.tools.main import main
from tests.makers import missing_package
from tests.primitives.objects.head_robot import head_robot

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "reference" / "makers_robots.md"
SHIPPED = {
    "cart": "cart/robot.yaml",
    "cart/mecanum": "cart/mecanum.yaml",
    "librarian": "librarian/robot.yaml",
}


def test_table_says_which_backend_and_primitive_a_robot_can_do(tmp_path: Path) -> None:
    files = {name: SHIPPED_FOLDER / path for name, path in SHIPPED.items()}
    rows = {row.robot: row for row in robot_table({**files, "head": head_robot(tmp_path / "head")})}
    assert {"can", "ros2", "kinematic"} <= set(rows["cart"].backends)
    assert "MOVE_TO" in rows["cart"].primitives and "MOVE_ARM" not in rows["cart"].primitives
    assert not {"can", "pybullet", "ros2"} & set(rows["cart/mecanum"].backends)
    assert {"LOOK_FOR", "PICK", "STACK"} <= set(rows["librarian"].primitives)
    assert {"LOOK_FOR", "PICK", "PLACE"} <= set(rows["head"].primitives)
    assert "STACK" not in rows["head"].primitives  # needs the camera on the hand
    assert "can" not in rows["head"].backends


def test_table_says_how_to_install_what_a_robot_needs() -> None:
    with patch.object(robot_parts, "package_folders", return_value=iter(())):
        (row,) = robot_table({"tiago": SHIPPED_FOLDER / "tiago" / "robot.yaml"})
    assert row.line(8) == "tiago     needs: pip install 'handcart[robots]'"


def test_table_is_for_robots_alone(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["list", "tasks", "--table"])
    assert ended.value.code == 2 and "handcart list robots --table" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["fetch", "husky", "husky/panda", "husky/ur5", "pr2", "tiago", "tiago/dual"])
def test_page_of_makers_robots_has_the_rows_of_the_table(name: str) -> None:
    folder, _, variant = name.partition("/")
    path = SHIPPED_FOLDER / folder / f"{variant or 'robot'}.yaml"
    if missing := missing_package(path):
        pytest.skip(f"the package {missing} is not installed")
    (row,) = robot_table({name: path})
    stated = [line.split(None, 1) for line in PAGE.read_text(encoding="utf-8").splitlines() if ": " in line]
    words = next(rest for first, rest in stated if first == name)
    assert words == row.line(0).split(None, 1)[1]
