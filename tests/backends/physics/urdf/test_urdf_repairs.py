"""Parts of a URDF that no engine accepts are repaired alike for all engines, and reported."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.physics.urdf.urdf_repairs import MIN_MASS_KG, repaired
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.kinematics.urdf_contents import LinkFacts, links_of

ROBOT = """<robot name="r">
  <link name="base">{inertial}<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="frame"/>
  <joint name="fixed" type="fixed"><parent link="base"/><child link="frame"/></joint>
  <link name="turns"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="turns"/><axis xyz="0 0 1"/></joint>
</robot>"""


def base_with(mass: float, *moments: float) -> str:
    """A robot whose base has these moments of inertia in [kg m²], turned by 0.7 rad."""
    ixx, iyy, izz = moments
    inertia = f'<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/>'
    words = f'<inertial><origin rpy="0.7 0 0"/><mass value="{mass}"/>{inertia}</inertial>'
    return ROBOT.format(inertial=words)


def base_of(urdf: str) -> LinkFacts:
    return links_of(urdf)[0]


@pytest.mark.parametrize(
    ("mass", "moments", "words"),
    [
        (2.0, (0.02, 0.03, 0.04), ""),
        (2.0, (0.01, 0.03, 0.04), ""),
        (2.0, (0.01, 0.02, 0.04), "no body has its inertia; 0.01 kg m² put on each of its moments"),
        (2.0, (0.0, 0.03, 0.03), "no body has its inertia; 1e-06 kg m² put on each of its moments"),
        (0.0, (0.01, 0.03, 0.04), "a mass of 0 kg; given 1e-06 kg and 1e-06 kg m²"),
    ],
)
def test_a_body_gets_mass_and_inertia_that_bodies_have(
    mass: float, moments: tuple[float, float, float], words: str
) -> None:
    urdf = base_with(mass, *moments)
    mended, repairs = repaired(urdf)
    small, middle, large = np.linalg.eigvalsh(base_of(mended).inertia)
    assert small > 0.0
    assert large < small + middle
    assert [repair.what for repair in repairs if repair.link == "base"] == ([words] if words else [])
    if not words:
        assert base_of(mended).inertia == pytest.approx(base_of(urdf).inertia, rel=1e-6)


def test_frames_are_light_and_only_those_that_move_are_told() -> None:
    mended, repairs = repaired(base_with(2.0, 0.02, 0.03, 0.04))
    assert [facts.mass for facts in links_of(mended)] == [2.0, MIN_MASS_KG, MIN_MASS_KG]
    assert [repair.link for repair in repairs] == ["turns"]


def test_a_mass_without_inertia_is_given_one() -> None:
    mended, repairs = repaired(ROBOT.format(inertial='<inertial><mass value="2"/></inertial>'))
    assert base_of(mended).inertia == pytest.approx(np.diag([MIN_MASS_KG] * 3))
    assert repairs[0].link == "base"


def test_shipped_robots_are_taken_as_they_are(physics: type[PhysicsBackend], world: WorldFile) -> None:
    robot = load_robot("librarian")
    backend = physics(robot, world, 0)
    backend.close()
    assert list(backend.remarks) == []


def test_what_isnt_as_the_file_says_is_told_with_its_line(
    physics: type[PhysicsBackend], world: WorldFile, tmp_path: Path
) -> None:
    robot = spoiled(tmp_path)
    with physics(robot, world, 0) as backend:
        (remark,) = backend.remarks
    assert remark.startswith(f"{tmp_path / 'robot' / 'librarian.urdf'}:{line_of(robot, 'base')}:")
    assert "link 'base': no body has its inertia; " in remark


def spoiled(folder: Path) -> RobotFile:
    """The librarian, its base's inertia about z ten times as large."""
    shipped = load_robot("librarian").folder
    shutil.copytree(shipped, folder / "robot")
    urdf = folder / "robot" / "librarian.urdf"
    text = urdf.read_text(encoding="utf-8")
    base = text.index('<link name="base">')
    at = text.index('izz="', base) + len('izz="')
    end = text.index('"', at)
    urdf.write_text(f"{text[:at]}{10 * float(text[at:end])}{text[end:]}", encoding="utf-8")
    return load_robot(str(folder / "robot" / "robot.yaml"))


def line_of(robot: RobotFile, link: str) -> int:
    found = robot.whole.finding("link", link, "")
    assert found is not None
    return found.line
