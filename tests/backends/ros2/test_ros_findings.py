"""Faults of the section `ros2` at their places in the robot's file."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError

SECTION = """\
ros2:
  arm:
    actions: {arm/goals: [joint_1, jiont_2, joint_3]}
    controllers: {arm/commands: [joint_3, joint_4, joint_5, joint_6]}
  names: {wrist: tool}
  cameras: {hand: {}}
"""


def written(folder: Path, section: str) -> Path:
    text = (SHIPPED_FOLDER / "librarian" / "robot.yaml").read_text()
    head, _, rest = text.partition("ros2: {}")
    urdf = (SHIPPED_FOLDER / "librarian" / "librarian.urdf").read_text()
    (folder / "librarian.urdf").write_text(urdf)
    (folder / "robot.yaml").write_text(f"{section}{head}{rest.partition(chr(10))[2]}")
    return folder / "robot.yaml"


def test_faults_of_the_section_are_found_at_their_places(tmp_path: Path) -> None:
    path = written(tmp_path, SECTION)
    with pytest.raises(FileError) as refused:
        load_robot(str(path))
    places = {(finding.line, finding.column): finding.message for finding in refused.value.findings}
    assert places[2, 3] == "no controller has the joint 'joint_2'; needed: one"
    assert places[3, 36].startswith("the arm has no joint 'jiont_2'; did you mean 'joint_2'?")
    assert places[3, 45] == "2 controllers have the joint 'joint_3'; needed: one"
    assert places[5, 11].startswith("the arm has no joint 'wrist'")
    assert places[6, 13].startswith("the robot has no further camera 'hand'")
    assert len(places) == len(refused.value.findings) == 5


def test_a_joint_that_one_controller_names_twice_is_called_so(tmp_path: Path) -> None:
    joints = ", ".join(f"joint_{number}" for number in (1, 2, 3, 4, 5, 6, 1))
    path = written(tmp_path, f"ros2:\n  arm:\n    controllers: {{arm/commands: [{joints}]}}\n")
    with pytest.raises(FileError, match="the joint 'joint_1' is named twice; allowed: once"):
        load_robot(str(path))


def test_section_does_not_keep_a_simulated_robot_from_running(tmp_path: Path) -> None:
    assert load_robot(str(written(tmp_path, SECTION)), drives=False).ros2 is not None
