"""The robot's postures are checked without motion: self-collisions, and parts beyond the footprint."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.robot_report.posture_findings import posture_facts, posture_findings
from handcart.tools.checks.check_robot import robot_facts

INTO_ITSELF = "[0, 40, 169, 0, 0, 0]"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The librarian's files."""
    shutil.copytree(robot_path("librarian").parent, tmp_path / "robot", dirs_exist_ok=True)
    return tmp_path / "robot"


def changed(folder: Path, posture: str, angles: str) -> tuple[str, int]:
    """The path of the robot's file with another posture, and the posture's line."""
    path = folder / "robot.yaml"
    lines = path.read_text(encoding="utf-8").splitlines()
    number = next(i for i, line in enumerate(lines) if line.strip().startswith(f"{posture}:"))
    indent = lines[number][: len(lines[number]) - len(lines[number].lstrip())]
    lines[number] = f"{indent}{posture}: {angles}"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path), number + 1


def test_the_shipped_postures_touch_nothing() -> None:
    for name in ("librarian", "toyama", "atrv", "el_verde", "xarm_cart"):
        assert list(posture_findings(name, load_robot(name))) == []
    assert posture_facts(load_robot("cart")) == []


def test_posture_with_self_contact_is_reported_with_its_line(folder: Path) -> None:
    path, line = changed(folder, "look_at_tag", INTO_ITSELF)
    found = [str(finding) for finding in posture_findings(path, load_robot(path))]
    assert len(found) == 1
    assert found[0].startswith(f"{path}:{line}:")
    assert "in posture 'look_at_tag' the robot touches itself: " in found[0]
    assert "column with link_4" in found[0]


def test_a_posture_to_drive_with_that_stands_out_is_told(folder: Path) -> None:
    path, line = changed(folder, "carry", "[0, 0, 10, 0, 0, 0]")
    (found,) = [
        str(finding) for finding in posture_findings(path, load_robot(path)) if "footprint" in str(finding)
    ]
    assert found.startswith(f"{path}:{line}:")
    assert "the base drives in posture 'carry'" in found
    assert "allowed: within the footprint, 0.34 m" in found
    path, _ = changed(folder, "look_at_tag", "[0, 0, 10, 0, 0, 0]")
    assert not [
        finding
        for finding in posture_findings(path, load_robot(path))
        if "look_at_tag" in str(finding) and "footprint" in str(finding)
    ]


def test_all_bodies_of_a_link_may_stand_out(folder: Path) -> None:
    """Whichever of them comes last in the URDF."""
    urdf = folder / "librarian.urdf"
    text, own = urdf.read_text(encoding="utf-8"), '<link name="hand">'
    assert own in text
    rod = '<collision><origin xyz="0.5 0 0"/><geometry><box size="0.02 0.02 0.02"/></geometry></collision>'
    urdf.write_text(text.replace(own, own + rod), encoding="utf-8")
    (home,) = [fact for fact in posture_facts(load_robot(str(folder / "robot.yaml"))) if fact.name == "home"]
    (plain,) = [fact for fact in posture_facts(load_robot("librarian")) if fact.name == "home"]
    assert home.farthest == "hand"
    assert home.reach > plain.reach + 0.05


def test_check_tells_it(folder: Path) -> None:
    path, line = changed(folder, "look_at_tag", INTO_ITSELF)
    facts = robot_facts(Path(path), None, quick=True)
    assert [warning for warning in facts["warnings"] if warning.startswith(f"{path}:{line}:")]
