"""A robot whose collision meshes are COLLADA in millimetres, and whose wheels state no effort."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.physics.urdf.sound_urdf import sound_urdf
from handcart.backends.simulation.world.world_model import world_model
from handcart.files.errors import FileError
from handcart.robotics.kinematics.urdf_contents import bodies_of
from tests.backends.physics.mesh_robot import write_robot

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})


@pytest.fixture
def robot(tmp_path: Path) -> RobotFile:
    return load_robot(str(write_robot(tmp_path)))


def test_collada_unit_is_applied_and_up_axis_is_not(robot: RobotFile) -> None:
    sizes = {
        each.name: np.ptp(each.points, axis=0)
        for each in bodies_of(robot.urdf_text())
        if hasattr(each, "points")
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
    assert [each.link for each in sound.repairs if "floor" in each.what] == ["body"]
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
