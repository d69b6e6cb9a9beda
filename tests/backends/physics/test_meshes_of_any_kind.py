"""A robot whose collision meshes are COLLADA in millimetres, and whose wheels state no effort."""

from __future__ import annotations

from itertools import product
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

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})
CUBE = np.array(list(product((-0.5, 0.5), repeat=3)))
FACES = (
    0,
    1,
    3,
    0,
    3,
    2,
    4,
    6,
    7,
    4,
    7,
    5,
    0,
    4,
    5,
    0,
    5,
    1,
    2,
    3,
    7,
    2,
    7,
    6,
    0,
    2,
    6,
    0,
    6,
    4,
    1,
    5,
    7,
    1,
    7,
    3,
)
COLLADA = """\
<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00</created><modified>2026-01-01T00:00:00</modified>{unit}
<up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g" name="g"><mesh><source id="p">
<float_array id="pa" count="24">{corners}</float_array><technique_common>
<accessor source="#pa" count="8" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="12">
<input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n" name="n">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
ROBOT = """\
format: handcart-robot/1
urdf: robot.urdf
links: {base: foot}
drive: {left: l, right: r, wheel_radius_m: 0.1, tread_m: 0.5, top_speed_m_s: 0.5,
        top_turn_deg_s: 60, acceleration_m_s2: 0.5, turn_acceleration_deg_s2: 90}
period_s: 0.05
footprint_radius_m: 0.4
localizer: odometry
errors: {none: true}
tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}
"""
MASS = (
    '<inertial><mass value="{0}"/><inertia ixx="{1}" iyy="{1}" izz="{1}" ixy="0" ixz="0" iyz="0"/></inertial>'
)
MESH = '<collision><origin xyz="0 0 {0}"/><geometry><mesh filename="{1}"/></geometry></collision>'
SIDE = """\
<link name="{0}_rim">{mass}<collision><geometry><mesh filename="wheel.dae"/></geometry></collision></link>
<joint name="{0}" type="continuous"><parent link="body"/><child link="{0}_rim"/><origin xyz="0 {1} 0.1"/>
<axis xyz="0 1 0"/><dynamics damping="20" friction="10"/></joint>
"""
BALL = """\
<link name="caster_{0}">{mass}<collision><geometry><sphere radius="0.04"/></geometry></collision></link>
<joint name="caster_{0}" type="fixed"><parent link="body"/><child link="caster_{0}"/>
<origin xyz="{0} 0 0.04"/></joint>
"""


def write_collada(path: Path, size: tuple[float, float, float], metres: float | None = None) -> None:
    """Write a box of a size in [m], with its corners in a unit of so many metres."""
    unit = "" if metres is None else f'<unit meter="{metres}" name="unit"/>'
    corners = (CUBE * size / (metres or 1.0)).ravel()
    words = {"corners": " ".join(map(str, corners)), "faces": " ".join(map(str, FACES))}
    path.write_text(COLLADA.format(unit=unit, **words), encoding="utf-8")


@pytest.fixture
def robot(tmp_path: Path) -> RobotFile:
    """Its body in mm reaches down to the floor; its wheels are octagons' kin: boxes."""
    write_collada(tmp_path / "body.dae", (0.4, 0.3, 0.2), 0.001)
    write_collada(tmp_path / "wheel.dae", (0.2, 0.05, 0.2), 0.0254)
    light = MASS.format(0.5, 0.002)
    text = f'<robot name="r"><link name="foot"/><link name="body">{MASS.format(20, 0.5)}'
    text += MESH.format(0.1, "body.dae") + "</link>"
    text += '<joint name="on" type="fixed"><parent link="foot"/><child link="body"/></joint>'
    text += SIDE.format("l", 0.25, mass=light) + SIDE.format("r", -0.25, mass=light)
    text += BALL.format(0.15, mass=light) + BALL.format(-0.15, mass=light)
    (tmp_path / "robot.urdf").write_text(text + "</robot>", encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    return load_robot(str(tmp_path / "robot.yaml"))


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
