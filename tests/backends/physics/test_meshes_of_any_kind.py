"""A robot whose collision meshes are COLLADA in millimetres, and whose wheels state no effort."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.physics.urdf.sound_urdf import sound_urdf
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.errors import FileError
from handcart.robotics.kinematics.urdf_contents import bodies_of
from tests.backends.physics.mesh_robot import MASS, write_robot

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})


@pytest.fixture
def robot(tmp_path: Path) -> RobotFile:
    return load_robot(str(write_robot(tmp_path)))


def test_collada_unit_is_applied_and_up_axis_is_not(robot: RobotFile) -> None:
    sizes = {
        item.name: np.ptp(item.points, axis=0)
        for item in bodies_of(robot.urdf_text())
        if hasattr(item, "points")
    }
    assert sizes["body"] == pytest.approx([0.4, 0.3, 0.2], abs=1e-6)
    assert sizes["left_wheel"] == pytest.approx([0.2, 0.05, 0.2], abs=1e-6)


@pytest.mark.parametrize("metres", ["0", "-1", "nan", "much"])
def test_collada_unit_without_a_length_is_rejected(robot: RobotFile, metres: str) -> None:
    mesh = robot.folder / "body.dae"
    mesh.write_text(mesh.read_text().replace('meter="0.001"', f'meter="{metres}"'), encoding="utf-8")
    with pytest.raises(
        FileError, match=rf"robot.urdf:1:\d+: link 'body': mesh 'body.dae': its unit is '{metres}' m"
    ):
        load_robot(str(robot.folder / "robot.yaml"))


def test_engines_get_hulls_wheels_that_roll_and_clear_the_floor(robot: RobotFile) -> None:
    sound = sound_urdf(robot)
    (hull,) = sound.hulls.values()
    assert hull.points[:, 2].min() == pytest.approx(-0.09, abs=1e-9)  # 10 mm above the floor
    assert [repair.link for repair in sound.repairs if "floor" in repair.what] == ["body"]
    assert sound.text.count("<cylinder") == 2


def test_base_with_such_meshes_drives_as_commanded(physics: type[PhysicsBackend], robot: RobotFile) -> None:
    backend = physics(robot, EMPTY, 0)
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert base is not None
    for speed, turn_rate in [(0.3, 0.0)] * 40 + [(0.0, 0.5)] * 40:
        base.drive(speed, turn_rate)
        backend.step()
    at, contacts = backend.scene.base, list(backend.scene.contacts)
    backend.close()
    assert (at.x, at.y) == pytest.approx((0.6, 0.0), abs=0.02)
    assert at.theta == pytest.approx(1.0, abs=0.03)
    assert contacts == []


OVERLAPPING = """\
<link name="{0}">{mass}<collision><origin xyz="0 0 0.05"/><geometry><box size="0.1 0.1 0.1"/></geometry>
</collision></link><joint name="{0}" type="revolute"><parent link="body"/><child link="{0}"/>
<origin xyz="0 {1} 0.3"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="0.1" velocity="1"/></joint>
"""


def test_links_that_cannot_move_against_each_other_do_not_collide(
    physics: type[PhysicsBackend], robot: RobotFile
) -> None:
    """Two fingers that nobody moves overlap by 60 mm: they would push each other apart for ever."""
    urdf, light = robot.folder / "robot.urdf", MASS.format(0.1, 0.0005)
    two = "".join(OVERLAPPING.format(name, y, mass=light) for name, y in (("one", 0.0), ("other", 0.04)))
    urdf.write_text(urdf.read_text().replace("</robot>", two + "</robot>"), encoding="utf-8")
    backend = physics(load_robot(str(robot.folder / "robot.yaml")), EMPTY, 0)
    for _ in range(20):
        backend.step()
    poses = [backend.link_pose(name) for name in ("one", "other")]
    backend.close()
    assert poses[0][:3, :3] == pytest.approx(np.eye(3), abs=0.01)
    assert poses[1][:3, :3] == pytest.approx(np.eye(3), abs=0.01)
    assert poses[1][1, 3] - poses[0][1, 3] == pytest.approx(0.04, abs=1e-3)
