"""Files of robots that people own: sound without their packages, and complete with them."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.loading.robot_model import model_for
from handcart.backends.urdf.packages import PACKAGE_SOURCES
from handcart.files.models.loading import load_document
from handcart.files.yaml.yaml_document import read_document
from tests.makers import makers_robots, missing_package, packages_of

ROOT = Path(__file__).resolve().parents[3]
ROBOTS = makers_robots()


@pytest.mark.parametrize("name", ROBOTS)
def test_makers_file_keeps_the_schema_without_its_package(name: str) -> None:
    document = read_document(ROBOTS[name])
    robot = load_document(document, model_for(document)).value.read_in(ROBOTS[name].parent)
    assert robot.arm is None or {len(posture) for posture in robot.arm.postures.values()} == {
        len(robot.arm.joints)
    }
    for part in robot.parts:
        assert part.urdf.startswith("package://") or (ROBOTS[name].parent / part.urdf).is_file()


@pytest.mark.parametrize("name", ROBOTS)
def test_package_of_a_makers_file_has_a_known_source(name: str) -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    head = "".join(ROBOTS[name].read_text("utf-8").splitlines(keepends=True)[:2]).replace('"', "'")
    for package in packages_of(ROBOTS[name]):
        source = PACKAGE_SOURCES[package]
        assert package == "pybullet_data" or f"pip install {source}" in head
        if extra := re.fullmatch(r"'handcart\[(\w+)\]'", source):
            assert any(package.removesuffix("_data") in item for item in extras[extra[1]])


def test_no_mesh_of_a_maker_is_copied() -> None:
    folder = next(iter(ROBOTS.values())).parents[1]
    assert {path.suffix for path in folder.glob("*/*") if path.is_file()} <= {".py", ".yaml", ".urdf"}


@pytest.mark.parametrize("name", ROBOTS)
def test_makers_robot_is_sound_and_stands_free_in_its_postures(name: str) -> None:
    if missing := missing_package(ROBOTS[name]):
        pytest.skip(f"the package {missing} is not installed")
    import numpy as np

    from handcart.robotics.manipulation.motions.collision_model import CollisionModel

    robot = load_robot(name)
    if robot.arm is not None:
        collision = CollisionModel(robot.arm_model())
        for posture in robot.arm.postures:
            assert collision.contacts(np.array(robot.posture(posture))) == []


def test_check_takes_a_robots_name(capsys: pytest.CaptureFixture[str]) -> None:
    from handcart.tools.main import main

    with pytest.raises(SystemExit) as ended:
        main(["check", "cart/skid"])
    assert ended.value.code == 0 and "cart/skid: no fault found" in capsys.readouterr().out
